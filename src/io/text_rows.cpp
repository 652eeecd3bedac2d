// std::from_chars does not depend on the locale and rounds correctly.
#include "io/text_rows.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <limits>

#include "core/parallel.h"
#include "io/text_numbers.h"

namespace pointbake {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f'; }
bool is_separator(char c) { return c == ',' || c == ';'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Neither blank nor separator: such characters lie above all of them but ';'.
bool is_plain(char c) { return c > ',' && c != ';'; }

std::string_view trimmed(std::string_view text) {
    while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
    while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
    return text;
}

/// Which of the wanted columns each field goes to.
constexpr std::size_t kUnwanted = ~std::size_t{0};
std::vector<std::size_t> places_of(std::size_t num_columns, std::span<const std::size_t> wanted) {
    std::vector<std::size_t> places(num_columns, kUnwanted);
    for (std::size_t k = 0; k < wanted.size(); ++k) places[wanted[k]] = k;
    return places;
}

/// Reads one row into the block's columns, which are as long as the block. Returns what is wrong
/// with it. `has_empty_end`: one more empty field may be thought behind it.
std::string_view read_row(Fields fields, std::span<const std::size_t> places, std::size_t row,
                          bool has_empty_end, TextBlock& block) {
    for (const std::size_t place : places) {
        if (fields.at_end()) {
            if (!has_empty_end) return "too few columns";
            has_empty_end = false;
            if (place != kUnwanted) block.columns[place][row] = kNone;
            continue;
        }
        if (place == kUnwanted) {
            fields.word();
            continue;
        }
        if (!fields.number(block.columns[place][row])) return "text that is no number";
        if (fields.has_point()) block.has_point[place] = 1;
    }
    return fields.at_end() || fields.at_open_end() ? std::string_view{} : "too many columns";
}

}  // namespace

void Fields::skip_blanks() {
    while (at_ != end_ && is_blank(*at_)) ++at_;
}

void Fields::skip_separator() {
    is_open_ = false;
    // Mostly one blank.
    if (end_ - at_ > 1 && *at_ == ' ' && is_plain(at_[1])) {
        ++at_;
        return;
    }
    skip_blanks();
    if (at_ == end_ || !is_separator(*at_)) return;
    ++at_;
    is_open_ = true;
    skip_blanks();
}

bool Fields::is_end_of_field(const char* p) const {
    if (only_separators_)
        while (p != end_ && is_blank(*p)) ++p;
    return p == end_ || is_separator(*p) || is_blank(*p);
}

bool Fields::short_number(double& value) {
    const ShortNumber number = read_short_number(at_, end_);
    if (number.end == nullptr || !is_end_of_field(number.end)) return false;
    value = number.value;
    has_point_ = number.has_point;
    at_ = number.end;
    skip_separator();
    return true;
}

bool Fields::number(double& value) {
    if (short_number(value)) return true;
    has_point_ = false;
    if (at_open_end() || (at_ != end_ && is_separator(*at_))) {
        value = kNone;
        skip_separator();
        return true;
    }
    const auto [stop, error] = std::from_chars(at_, end_, value);
    if (error != std::errc{} || !is_end_of_field(stop)) return odd_number(value);
    has_point_ = std::find(at_, stop, '.') != stop;
    at_ = stop;
    skip_separator();
    return true;
}

bool Fields::odd_number(double& value) {
    const bool is_quoted = at_ != end_ && *at_ == '"';
    const std::string_view text = word();
    if (is_quoted && text.empty()) {
        value = kNone;
        return true;
    }
    NumberReader reader(text);
    has_point_ = text.find('.') != std::string_view::npos;
    return reader.next(value) && reader.at_end();
}

std::string_view Fields::word() {
    const char* begin = at_;
    if (at_ != end_ && *at_ == '"') {
        const char* quote = std::find(at_ + 1, end_, '"');
        // Two quotes are one that belongs to the text.
        while (quote != end_ && quote + 1 != end_ && quote[1] == '"')
            quote = std::find(quote + 2, end_, '"');
        if (quote != end_) {
            const std::string_view inside(begin + 1, quote);
            at_ = quote + 1;
            skip_separator();
            return inside;
        }
    }
    while (at_ != end_ && (only_separators_ || !is_blank(*at_)) && !is_separator(*at_)) ++at_;
    const std::string_view found = trimmed({begin, at_});
    skip_separator();
    return found;
}

bool is_text_comment(std::string_view line) {
    const std::size_t begin = line.find_first_not_of(" \t");
    return begin != std::string_view::npos && (line[begin] == '#' || line.substr(begin, 2) == "//");
}

bool is_text_count(std::string_view line) {
    line = trimmed(line);
    return !line.empty() && std::all_of(line.begin(), line.end(), is_digit);
}

bool is_text_row(std::string_view line, const TextSyntax& syntax) {
    line = trimmed(line);
    if (line.empty() || line.front() == '#' || line.substr(0, 2) == "//") return false;
    return !syntax.has_counts || !is_text_count(line);
}

std::string_view take_line(std::string_view& text, char line_end) {
    const void* end = std::memchr(text.data(), line_end, text.size());
    const std::size_t size =
        end == nullptr ? text.size()
                       : static_cast<std::size_t>(static_cast<const char*>(end) - text.data());
    const std::string_view line = text.substr(0, size);
    text.remove_prefix(end == nullptr ? size : size + 1);
    return trimmed(line);
}

bool has_tab_behind(std::string_view line, std::string_view rest) {
    const std::string_view behind(line.data() + line.size(), rest.data());
    return behind.find('\t') != std::string_view::npos;
}

TextRows::TextRows(std::string_view text, char line_end, const Context& context, TextSyntax syntax)
    : text_(text), line_end_(line_end), syntax_(syntax) {
    for (const std::string_view part : cut_text(text, line_end)) chunks_.push_back({part});
    parallel_chunks(context, chunks_.size(), [&](std::size_t i) {
        Chunk& chunk = chunks_[i];
        for (std::string_view rest = chunk.text; !rest.empty();) {
            const std::string_view line = take_line(rest, line_end_);
            if (is_text_row(line, syntax_)) {
                ++chunk.num_rows;
            } else if (syntax_.has_counts && is_text_count(line)) {
                double count = 0.0;
                NumberReader(line).next(count);
                chunk.promised += count;
            }
        }
    });
    for (Chunk& chunk : chunks_) {
        chunk.first_row = num_rows_;
        num_rows_ += chunk.num_rows;
        promised_ += chunk.promised;
    }
}

std::size_t TextRows::byte_of_row(std::size_t row) const {
    for (const Chunk& chunk : chunks_) {
        if (row >= chunk.first_row + chunk.num_rows) continue;
        std::size_t at = chunk.first_row;
        for (std::string_view rest = chunk.text; !rest.empty();) {
            const char* begin = rest.data();
            if (is_text_row(take_line(rest, line_end_), syntax_) && at++ == row)
                return static_cast<std::size_t>(begin - text_.data());
        }
    }
    return text_.size();
}

void TextRows::read(std::size_t num_columns, std::span<const std::size_t> wanted,
                    const Context& context,
                    const std::function<void(const TextBlock&)>& body) const {
    const std::vector<std::size_t> places = places_of(num_columns, wanted);
    parallel_chunks(context, chunks_.size(), [&](std::size_t index) {
        const Chunk& chunk = chunks_[index];
        TextBlock block{index, chunk.first_row, chunk.num_rows, {}, {}, {}};
        block.has_point.assign(wanted.size(), 0);
        block.columns.assign(wanted.size(), std::vector<double>(chunk.num_rows));
        std::size_t row = 0;
        for (std::string_view rest = chunk.text; !rest.empty();) {
            const std::string_view line = take_line(rest, line_end_);
            if (!is_text_row(line, syntax_)) continue;
            const std::size_t size =
                syntax_.ends_at_hash ? std::min(line.find('#'), line.size()) : line.size();
            const Fields fields(line.substr(0, size), syntax_.only_separators);
            const std::string_view problem =
                read_row(fields, places, row, has_tab_behind(line, rest), block);
            if (!problem.empty()) {
                for (std::vector<double>& column : block.columns) column[row] = kNone;
                block.bad.push_back({block.first_row + row, line, problem});
            }
            ++row;
        }
        body(block);
    });
}

std::size_t line_of_byte(std::string_view text, std::size_t byte, char line_end) {
    const auto end = text.begin() + static_cast<std::ptrdiff_t>(std::min(byte, text.size()));
    return 1 + static_cast<std::size_t>(std::count(text.begin(), end, line_end));
}

char line_end_of(std::string_view text) {
    constexpr std::size_t kLookAt = std::size_t{1} << 16;
    const std::string_view begin = text.substr(0, kLookAt);
    const bool is_old_mac =
        begin.find('\n') == std::string_view::npos && begin.find('\r') != std::string_view::npos;
    return is_old_mac ? '\r' : '\n';
}

}  // namespace pointbake
