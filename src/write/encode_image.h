// Images as files in memory: JPEG and WebP, which lose some of them, and what an image is written
// as.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "pointbake/context.h"
#include "pointbake/types.h"
#include "pointbake/write.h"

namespace pointbake {

/// A JPEG or WebP file of an RGB image. JPEG halves the resolution of chroma below quality 90;
/// WebP, which always does, loses nothing at 100. Throws Error{kLimit} for an image larger than the
/// format holds.
std::vector<std::byte> encode_lossy(const Image& image, const ImageOptions& options,
                                    const Context& context = {});

/// The image's own file if it has one, else a PNG.
std::vector<std::byte> image_file(const Image& image, const Context& context = {});

/// ".jpg" and "image/jpeg" of what image_file() makes.
struct FileKind {
    std::string_view extension, mime_type;
};
FileKind file_kind(const Image& image);

/// Longest side that a format holds.
int longest_side(ImageFormat format);

}  // namespace pointbake
