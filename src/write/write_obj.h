// Wavefront OBJ with its materials.
#pragma once

#include <filesystem>

#include "pointbake/write.h"

namespace pointbake {

/// The model as .obj in full double, with .mtl and .png beside it.
WriteReport write_obj(const TexturedMesh& model, const std::filesystem::path& path,
                      const WriteOptions& options, const Context& context);

}  // namespace pointbake
