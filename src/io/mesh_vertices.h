// The vertices of a mesh as a point cloud.
#pragma once

#include <filesystem>

#include "pointbake/load.h"

namespace pointbake {

/// Points and faces of a mesh that was read from `path`; its textures are left out, with a note.
LoadResult vertices_as_points(const TexturedMesh& model, const std::filesystem::path& path,
                              const Context& context);

}  // namespace pointbake
