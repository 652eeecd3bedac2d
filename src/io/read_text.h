// Tables of numbers in text: XYZ, TXT, CSV, ASC, PTS, PWN.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>

#include "io/point_table.h"
#include "io/text_layout.h"
#include "pointbake/load.h"

namespace pointbake {

/// `path` is for messages, and its extension tells PTS and PWN. Throws Error{kInvalidInput,
/// kInvalidOption, kLimit, kEmpty}.
LoadResult read_text(std::string_view text, const TextLayout& layout,
                     const std::filesystem::path& path, const LoadOptions& options,
                     const Context& context);

/// The rows alone, of a text of another format that holds a table from layout.begin to layout.end.
PointRows read_text_points(std::string_view text, const TextLayout& layout,
                           const std::filesystem::path& path, const LoadOptions& options,
                           const Context& context);

/// Whether files of this extension are such tables, whatever they hold.
bool is_text_extension(std::string_view extension);

}  // namespace pointbake
