// The vertices of a mesh as a point cloud.
#pragma once

#include <filesystem>

#include "pointbake/load.h"

namespace pointbake {

/// Points and faces of a mesh that was read from `path`; its textures are left out, with a note.
/// `kind`: "OBJ", ... for the report.
LoadResult vertices_as_points(const TexturedMesh& model, const std::string& kind,
                              const std::filesystem::path& path, const Context& context);

/// The faces that came with a cloud, as a mesh. Throws Error{kInvalidInput} if there are none.
TexturedMesh faces_as_mesh(LoadResult loaded, const std::filesystem::path& path);

}  // namespace pointbake
