// E57 files (ASTM E2807): several scans, each with a pose of its own.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "pointbake/load.h"

namespace pointbake {

bool is_e57(std::span<const std::byte> bytes);

/// `path` is for messages. Throws Error{kInvalidInput, kUnsupported, kLimit, kEmpty}.
LoadResult read_e57(std::span<const std::byte> bytes, const std::filesystem::path& path,
                    const Context& context);

}  // namespace pointbake
