// STL output.
#pragma once

#include <filesystem>

#include "pointbake/context.h"
#include "pointbake/write.h"

namespace pointbake {

/// Binary STL: triangles alone.
WriteReport write_stl(const TexturedMesh& model, const std::filesystem::path& path,
                      const WriteOptions& options, const Context& context);

}  // namespace pointbake
