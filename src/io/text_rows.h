// Rows of numbers in text, decoded in blocks of lines on several threads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "pointbake/context.h"

namespace pointbake {

/// What the lines of a text are like.
struct TextSyntax {
    bool only_separators = false;  ///< blanks do not separate, commas and semicolons do
    bool has_counts = false;       ///< a line with a lone whole number is a count, as PTS has
    bool ends_at_hash = false;     ///< a comment may follow a row
};

/// The fields of one line. They are separated by blanks or by one comma or semicolon, with or
/// without blanks; two separators in a row have an empty field between them, and one at the end of
/// the line has an empty field behind it.
class Fields {
 public:
    explicit Fields(std::string_view line, bool only_separators = false)
        : at_(line.data()), end_(line.data() + line.size()), only_separators_(only_separators) {
        skip_blanks();
    }

    bool at_end() const { return at_ == end_ && !is_open_; }
    /// Whether there is nothing left but an empty field behind the last separator.
    bool at_open_end() const { return at_ == end_ && is_open_; }
    /// Whether the field is a number; an empty field is NaN. Reads what NumberReader reads, and
    /// numbers in double quotes.
    bool number(double& value);
    /// Whether number() read one with a point.
    bool has_point() const { return has_point_; }
    /// The field as it is, without double quotes around it; a double quote in it stays doubled.
    std::string_view word();

 private:
    void skip_blanks();
    void skip_separator();
    bool is_end_of_field(const char* p) const;
    bool short_number(double& value);
    bool odd_number(double& value);

    const char* at_;
    const char* end_;
    bool only_separators_;
    bool is_open_ = false;  ///< behind a separator
    bool has_point_ = false;
};

/// Whether a line is a row: not blank, no comment (# or //), and no lone count where such are.
bool is_text_row(std::string_view line, const TextSyntax& syntax = {});
bool is_text_count(std::string_view line);
bool is_text_comment(std::string_view line);

/// Takes the first line off `text`, without its end and without blanks around it.
std::string_view take_line(std::string_view& text, char line_end);
/// Whether tabs were among the blanks behind a line that take_line has just taken; `rest` is what
/// that left.
bool has_tab_behind(std::string_view line, std::string_view rest);

struct BadTextRow {
    std::size_t row = 0;
    std::string_view line;
    std::string_view problem;
};

/// Consecutive rows. Rows that are bad hold NaN.
struct TextBlock {
    std::size_t index = 0;
    std::size_t first_row = 0, num_rows = 0;
    std::vector<std::vector<double>> columns;  ///< those asked for
    std::vector<std::uint8_t> has_point;       ///< per column: a number was written with a point
    std::vector<BadTextRow> bad;
};

class TextRows {
 public:
    /// Keeps a view of the text. Counts the rows.
    TextRows(std::string_view text, char line_end, const Context& context, TextSyntax syntax = {});

    std::size_t num_rows() const { return num_rows_; }
    std::size_t num_blocks() const { return chunks_.size(); }
    /// Sum of the lone counts between the rows.
    double promised() const { return promised_; }

    /// Where row `row` begins, in bytes; the end of the text if there are no more.
    std::size_t byte_of_row(std::size_t row) const;

    /// Calls body(block) for all blocks, in any order, on several threads; blocks are cut the same
    /// way for any number of threads. A row is bad if it has not `num_columns` fields, or if one of
    /// `wanted` is no number. An empty field behind them does no harm; a tab at the end of a line
    /// stands for one that lacks.
    void read(std::size_t num_columns, std::span<const std::size_t> wanted, const Context& context,
              const std::function<void(const TextBlock&)>& body) const;

 private:
    struct Chunk {
        std::string_view text;
        std::size_t first_row = 0, num_rows = 0;
        double promised = 0.0;
    };

    std::string_view text_;
    char line_end_;
    TextSyntax syntax_;
    std::vector<Chunk> chunks_;
    std::size_t num_rows_ = 0;
    double promised_ = 0.0;
};

/// Number of the line, from 1, that holds a byte of a text.
std::size_t line_of_byte(std::string_view text, std::size_t byte, char line_end);

/// '\r' where there are such and no '\n' near the beginning, else '\n'.
char line_end_of(std::string_view text);

}  // namespace pointbake
