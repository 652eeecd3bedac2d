// OFF of Geomview, as text: points, with normals and colours, and polygons.
#pragma once

#include <filesystem>
#include <string_view>

#include "pointbake/load.h"

namespace pointbake {

/// Whether the first word is OFF, COFF, NOFF, CNOFF, STOFF or the like.
bool is_off(std::string_view text);

/// `path` is for messages. Throws Error{kInvalidInput, kUnsupported, kLimit, kEmpty}.
LoadResult read_off(std::string_view text, const std::filesystem::path& path,
                    const Context& context);

}  // namespace pointbake
