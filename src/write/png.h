// PNG in memory.
#pragma once

#include <cstddef>
#include <vector>

#include "pointbake/context.h"
#include "pointbake/types.h"

namespace pointbake {

/// An 8-bit PNG: grey, grey with alpha, RGB or RGBA by num_channels. No colour space chunks: glTF
/// ignores them and sRGB is everyone's default. The same bytes for any number of threads. Throws
/// Error{kInvalidInput} if the image's sizes do not fit each other.
std::vector<std::byte> encode_png(const Image& image, const Context& context = {});

}  // namespace pointbake
