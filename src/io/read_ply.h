// What a PLY file holds, as a point cloud or as a mesh.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "pointbake/load.h"

namespace pointbake {

/// `path` is for messages. Throws Error{kInvalidInput, kUnsupported, kLimit, kEmpty}.
LoadResult read_ply_cloud(std::span<const std::byte> bytes, const std::filesystem::path& path,
                          const Context& context);

/// `path` also tells where the texture files lie that comments name.
TexturedMesh read_ply_mesh(std::span<const std::byte> bytes, const std::filesystem::path& path,
                           const Context& context);

}  // namespace pointbake
