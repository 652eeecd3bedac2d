// Rows of numbers in text, decoded in blocks of lines on several threads.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "pointbake/context.h"

namespace pointbake {

/// The fields of one line. They are separated by blanks or by one comma or semicolon, with or
/// without blanks; two separators in a row have an empty field between them.
class Fields {
 public:
    explicit Fields(std::string_view line) : at_(line.data()), end_(line.data() + line.size()) {
        skip_blanks();
    }

    bool at_end() const { return at_ == end_; }
    /// Whether the field is a number; an empty field is NaN. Reads what NumberReader reads, and
    /// numbers in double quotes.
    bool number(double& value);
    /// The field as it is, without double quotes around it.
    std::string_view word();

 private:
    void skip_blanks();
    void skip_separator();
    bool short_number(double& value);
    bool odd_number(double& value);

    const char* at_;
    const char* end_;
};

/// Whether a line is a row: not blank, no comment (# or //), and no lone count, as PTS has before
/// its points.
bool is_text_row(std::string_view line);
bool is_text_count(std::string_view line);
bool is_text_comment(std::string_view line);

/// Takes the first line off `text`, without its end and without blanks around it.
std::string_view take_line(std::string_view& text, char line_end);

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
    std::vector<BadTextRow> bad;
};

class TextRows {
 public:
    /// Keeps a view of the text. Counts the rows.
    TextRows(std::string_view text, char line_end, const Context& context);

    std::size_t num_rows() const { return num_rows_; }
    std::size_t num_blocks() const { return chunks_.size(); }
    /// Sum of the lone counts between the rows.
    double promised() const { return promised_; }

    /// Where row `row` begins, in bytes; the end of the text if there are no more.
    std::size_t byte_of_row(std::size_t row) const;

    /// Calls body(block) for all blocks, in any order, on several threads; blocks are cut the same
    /// way for any number of threads. A row is bad if it has not `num_columns` fields, or if one of
    /// `wanted` is no number.
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
    std::vector<Chunk> chunks_;
    std::size_t num_rows_ = 0;
    double promised_ = 0.0;
};

/// Number of the line, from 1, that holds a byte of a text.
std::size_t line_of_byte(std::string_view text, std::size_t byte, char line_end);

/// '\r' where there are such and no '\n' near the beginning, else '\n'.
char line_end_of(std::string_view text);

}  // namespace pointbake
