// PTX: scans as a scanner sees them, each with its place in the world.
#pragma once

#include <filesystem>
#include <string_view>

#include "pointbake/load.h"

namespace pointbake {

/// Whether the text begins with two counts, four lines of three numbers and four of four.
bool is_ptx(std::string_view text);

/// `path` is for messages. Throws Error{kInvalidInput, kLimit, kEmpty}.
LoadResult read_ptx(std::string_view text, const std::filesystem::path& path,
                    const Context& context);

}  // namespace pointbake
