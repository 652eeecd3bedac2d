// Reading textures.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

#include "pointbake/types.h"

namespace pointbake {

/// Whose image it is. A stranger's may be made to fill the memory, so it must not be packed too
/// well.
enum class Maker { kStranger, kThisProgram };

/// Decodes PNG, JPEG or WebP, told apart by content, to 8-bit RGB; alpha is left out. `name` is for
/// messages. Throws Error{kInvalidInput} for a damaged image, Error{kUnsupported} for another kind,
/// Error{kLimit} beyond 2^28 texels.
Image decode_image(std::span<const std::byte> bytes, const std::string& name,
                   Maker maker = Maker::kStranger);

/// The same for a file; throws Error{kIo} if it cannot be read.
Image read_image(const std::filesystem::path& path);

}  // namespace pointbake
