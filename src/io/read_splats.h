// Gaussian splats in formats of their own: .splat and .spz.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "pointbake/load.h"

namespace pointbake {

/// Whether the bytes, unpacked if they were gzip, begin like SPZ.
bool is_spz(std::span<const std::byte> bytes);

/// SPZ, versions 1 to 4. Coordinates stay as they are in the file: y up. `path` is for messages.
/// Throws Error{kInvalidInput, kUnsupported, kLimit, kEmpty}.
LoadResult read_spz(std::span<const std::byte> bytes, const std::filesystem::path& path,
                    const Context& context);

/// 32 bytes per splat, without a header: only the extension tells them. Throws as above.
LoadResult read_splat(std::span<const std::byte> bytes, const std::filesystem::path& path,
                      const Context& context);

}  // namespace pointbake
