// Meshes as PLY.
#pragma once

#include <filesystem>

#include "pointbake/write.h"

namespace pointbake {

/// The model as binary little-endian PLY; texture coordinates per face, as MeshLab reads them, with
/// .png beside it, or vertex colours.
WriteReport write_ply(const TexturedMesh& model, const std::filesystem::path& path,
                      const WriteOptions& options, const Context& context);

}  // namespace pointbake
