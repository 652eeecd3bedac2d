// Point Cloud Data files of the Point Cloud Library, versions 0.5 to 0.7.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "pointbake/load.h"

namespace pointbake {

/// Whether the first line that is no comment begins like a PCD header.
bool is_pcd(std::span<const std::byte> bytes);

/// `path` is for messages. Throws Error{kInvalidInput, kUnsupported, kLimit, kEmpty}.
LoadResult read_pcd(std::span<const std::byte> bytes, const std::filesystem::path& path,
                    const Context& context);

}  // namespace pointbake
