// LAS files of versions 1.0 to 1.5, all point formats, and LAZ (LASzip's compression of them).
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "pointbake/load.h"

namespace pointbake {

bool is_las(std::span<const std::byte> bytes);

/// `path` is for messages. Throws Error{kInvalidInput, kUnsupported, kLimit, kEmpty}.
LoadResult read_las(std::span<const std::byte> bytes, const std::filesystem::path& path,
                    const Context& context);

}  // namespace pointbake
