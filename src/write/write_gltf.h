// GLB and glTF 2.0.
#pragma once

#include <filesystem>

#include "pointbake/write.h"

namespace pointbake {

/// The model as one .glb, or as .gltf with .bin and .png beside it.
WriteReport write_gltf(const TexturedMesh& model, const std::filesystem::path& path,
                       const WriteOptions& options, const Context& context);

}  // namespace pointbake
