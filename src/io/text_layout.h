// What the columns of a text table are. Such files have no magic word: a table is what has lines of
// at least three numbers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/text_rows.h"

namespace pointbake {

struct TextLayout {
    char line_end = '\n';
    TextSyntax syntax;
    std::size_t begin = 0;  ///< of the rows: behind the header line
    std::size_t end = std::string_view::npos;
    std::size_t num_columns = 0;
    std::vector<bool> is_number;     ///< per column
    std::string header;              ///< the line that may hold names; empty = none
    std::vector<std::string> names;  ///< per column, if the header fits them and names x, y and z
};

/// Looks at the first lines. Nothing if they are no table. Throws Error{kInvalidInput} for decimal
/// commas, naming file and line.
std::optional<TextLayout> find_text_layout(std::string_view text, const std::string& path);

/// What is known of the values of a table's columns; the same for any order of adding.
class ColumnStats {
 public:
    explicit ColumnStats(std::size_t num_columns);

    /// Rows whose first column is NaN do not count. `has_point`: per column, whether a number was
    /// written with a point.
    void add(std::span<const std::vector<double>> columns, std::span<const std::uint8_t> has_point);
    void add(const ColumnStats& other);

    /// Whole numbers, and not 0.0 and 1.0, which are of a scale from 0 to 1.
    bool is_whole(std::size_t column) const {
        return columns_[column].is_whole && !is_whole_unit(column);
    }
    bool is_constant(std::size_t column) const {
        return columns_[column].min == columns_[column].max;
    }
    /// Three columns from `first` on: all integers from 0 to 255, or all in [0, 1].
    bool is_color(std::size_t first) const;
    /// All of length 1 as far as a few digits tell, or zero.
    bool is_normal(std::size_t first) const;
    /// What might be normals, too, but is 1.0 0.0 0.0, 0.0 1.0 0.0 and 0.0 0.0 1.0 in turn.
    bool is_class_color(std::size_t first) const;

 private:
    struct Column {
        bool is_whole = true;
        bool has_point = false;
        double min, max;
        bool is_unit = true;  ///< with the two columns after it: length 1 or 0
        bool is_zero = true;  ///< likewise: length 0
    };
    bool has_triple(std::size_t first) const { return first + 3 <= columns_.size(); }
    /// Nothing but 0.0 and 1.0.
    bool is_whole_unit(std::size_t column) const {
        const Column& c = columns_[column];
        return c.is_whole && c.has_point && c.min >= 0.0 && c.max <= 1.0;
    }

    std::vector<Column> columns_;
};

/// What the name of a file tells about its columns, where several fit.
struct TextHints {
    bool has_intensity_first = false;  ///< x y z i r g b, not x y z r g b a
    bool has_normals = false;          ///< nx ny nz, not the colours of classes
};

/// Names for the columns of a table without a header, by their number and ranges.
std::vector<std::string> names_by_content(const ColumnStats& stats, std::size_t num_columns,
                                          const TextHints& hints);

/// "x,y,z,-,red" as names; "-" becomes an empty one. Throws Error{kInvalidOption} unless x, y and z
/// are there and no name is twice.
std::vector<std::string> parse_columns(std::string_view text);

}  // namespace pointbake
