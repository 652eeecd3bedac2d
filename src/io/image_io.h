// Reading textures.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

#include "pointbake/types.h"

namespace pointbake {

/// Decodes PNG or JPEG, told apart by content, to 8-bit RGB; alpha is left out. `name` is for
/// messages. Throws Error{kInvalidInput} for a damaged image, Error{kUnsupported} for another kind,
/// Error{kLimit} beyond 2^28 texels.
Image decode_image(std::span<const std::byte> bytes, const std::string& name);

/// The same for a file; throws Error{kIo} if it cannot be read.
Image read_image(const std::filesystem::path& path);

}  // namespace pointbake
