// USDZ output.
#pragma once

#include <filesystem>

#include "pointbake/context.h"
#include "pointbake/write.h"

namespace pointbake {

/// One archive of the model as USD text and its images, PNG or JPEG. Throws Error{kUnsupported} for
/// a WebP image.
WriteReport write_usdz(const TexturedMesh& model, const std::filesystem::path& path,
                       const WriteOptions& options, const Context& context);

}  // namespace pointbake
