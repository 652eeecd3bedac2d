#include "io/text_layout.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "core/message.h"
#include "io/point_table.h"
#include "io/text_numbers.h"
#include "pointbake/vec.h"

namespace pointbake {
namespace {

constexpr std::size_t kSampleBytes = std::size_t{1} << 16;
constexpr std::size_t kLeastNumbers = 3;
constexpr std::size_t kMostHeaderLines = 16;
// Normals are often written with three digits.
constexpr double kUnitTolerance = 0.02;

std::string_view trimmed(std::string_view text, std::string_view what = " \t\r\"") {
    const std::size_t begin = text.find_first_not_of(what);
    if (begin == std::string_view::npos) return {};
    return text.substr(begin, text.find_last_not_of(what) - begin + 1);
}

enum class FieldKind : std::uint8_t { kNumber, kEmpty, kWord };
using LineKinds = std::vector<FieldKind>;

LineKinds kinds_of(std::string_view line, bool only_separators) {
    LineKinds kinds;
    for (Fields fields(line, only_separators); !fields.at_end();) {
        const std::string_view word = fields.word();
        NumberReader reader(word);
        double value = 0.0;
        kinds.push_back(word.empty()                            ? FieldKind::kEmpty
                        : reader.next(value) && reader.at_end() ? FieldKind::kNumber
                                                                : FieldKind::kWord);
    }
    return kinds;
}

bool is_row(const LineKinds& kinds) {
    return static_cast<std::size_t>(std::count(kinds.begin(), kinds.end(), FieldKind::kNumber)) >=
           kLeastNumbers;
}

bool has_no(FieldKind kind, const LineKinds& kinds) {
    return std::find(kinds.begin(), kinds.end(), kind) == kinds.end();
}

/// "1,2,3 255 0 0": several numbers between two commas.
bool has_numbers_in_a_field(std::string_view line) {
    for (Fields fields(line, true); !fields.at_end();) {
        const std::string_view word = fields.word();
        if (word.find_first_of(" \t") == std::string_view::npos) continue;
        if (has_no(FieldKind::kWord, kinds_of(word, false))) return true;
    }
    return false;
}

/// "1,5 2,25 -3": fields apart by blanks or semicolons, with at most one comma between digits, and
/// no point.
bool has_decimal_commas(std::string_view line) {
    if (line.find('.') != std::string_view::npos) return false;
    std::size_t num_fields = 0, num_commas = 0;
    constexpr std::string_view kApart = " \t\r;";
    for (std::size_t at = line.find_first_not_of(kApart); at != std::string_view::npos;
         at = line.find_first_not_of(kApart, at)) {
        const std::size_t end = std::min(line.find_first_of(kApart, at), line.size());
        const std::string_view field = line.substr(at, end - at);
        const std::size_t comma = field.find(',');
        ++num_fields;
        at = end;
        if (comma == std::string_view::npos) continue;
        const auto is_digit = [&](std::size_t i) {
            return i < field.size() && field[i] >= '0' && field[i] <= '9';
        };
        if (comma == 0 || !is_digit(comma - 1) || !is_digit(comma + 1) ||
            field.find(',', comma + 1) != std::string_view::npos)
            return false;
        ++num_commas;
    }
    return num_fields >= kLeastNumbers && num_commas > 0;
}

bool has_name(const std::vector<std::string>& names, std::string_view wanted) {
    return std::any_of(names.begin(), names.end(),
                       [&](const std::string& name) { return lower(name) == wanted; });
}

/// Other words for x, y and z, where these are not there themselves.
void translate_coordinates(std::vector<std::string>& names) {
    constexpr std::array<std::pair<std::string_view, std::string_view>, 10> kWords{
        {{"easting", "x"},
         {"northing", "y"},
         {"elevation", "z"},
         {"height", "z"},
         {"altitude", "z"},
         {"points:0", "x"},
         {"points:1", "y"},
         {"points:2", "z"},
         {"east", "x"},
         {"north", "y"}}};
    for (const auto& [word, coordinate] : kWords) {
        if (has_name(names, coordinate)) continue;
        for (std::string& name : names)
            if (lower(name) == word) name = coordinate;
    }
}

/// Where the first name ends: at a separator that is not in double quotes.
std::size_t end_of_name(std::string_view line, std::string_view separators) {
    std::size_t end = line.find_first_of(separators);
    if (line.starts_with('"')) {
        const std::size_t quote = line.find('"', 1);
        if (quote != std::string_view::npos) end = line.find_first_of(separators, quote);
    }
    return std::min(end, line.size());
}

/// The words of a header line; units in brackets are left out. Blanks separate only where nothing
/// else does.
std::vector<std::string> header_names(std::string_view line) {
    line = trimmed(line, " \t\r#/");
    const bool has_separators = line.find_first_of(",;\t") != std::string_view::npos;
    const std::string_view separators = has_separators ? ",;\t" : " ";
    std::vector<std::string> names;
    bool is_open = false;  // behind a separator
    while (!line.empty() || is_open) {
        const std::size_t end = end_of_name(line, separators);
        std::string_view name = trimmed(line.substr(0, end));
        name = trimmed(name.substr(0, name.find_first_of("[(")));
        if (!name.empty() || has_separators) names.emplace_back(name);
        is_open = has_separators && end < line.size();
        line.remove_prefix(std::min(end + 1, line.size()));
    }
    translate_coordinates(names);
    return names;
}

bool names_coordinates(const std::vector<std::string>& names) {
    return has_name(names, "x") && has_name(names, "y") && has_name(names, "z");
}

/// The first lines of a text, sorted into headers and rows.
class Sample {
 public:
    Sample(std::string_view text, char line_end, const std::string& path)
        : text_(text), line_end_(line_end), path_(path) {}

    std::optional<TextLayout> layout() {
        layout_.line_end = line_end_;
        const std::size_t size = size_of_comments() + kSampleBytes;
        std::string_view rest = text_.substr(0, size);
        if (rest.find('\0') != std::string_view::npos) return std::nullopt;
        // The last line may be cut.
        if (text_.size() > size) {
            const std::size_t end = rest.rfind(line_end_);
            if (end == std::string_view::npos) return std::nullopt;
            rest = rest.substr(0, end + 1);
        }
        take_lines(rest);
        layout_.syntax = {.only_separators = only_separators(), .has_counts = true};
        for (const Line& line : lines_) add(line);
        if (rows_.empty() || num_headers_ > kMostHeaderLines || num_bad_ > rows_.size())
            return std::nullopt;
        if (num_decimal_commas_ * 2 > rows_.size()) fail_decimal_commas();
        return count_columns() ? std::optional(std::move(layout_)) : std::nullopt;
    }

 private:
    struct Line {
        std::string_view text;
        std::size_t next = 0;  ///< byte at which the next one begins
        bool has_tab_behind = false;
    };

    /// Of the comments and blank lines in front, which may be longer than the sample.
    std::size_t size_of_comments() const {
        constexpr std::size_t kMost = std::size_t{1} << 24;
        const std::string_view begin = text_.substr(0, kMost);
        for (std::string_view rest = begin; !rest.empty();) {
            const std::size_t at = begin.size() - rest.size();
            const std::string_view line = take_line(rest, line_end_);
            if (!line.empty() && !is_text_comment(line)) return at;
        }
        return begin.size();
    }

    void take_lines(std::string_view rest) {
        while (!rest.empty()) {
            const std::string_view line = take_line(rest, line_end_);
            if (line.empty() || is_text_count(line)) continue;
            lines_.push_back({line, static_cast<std::size_t>(rest.data() - text_.data()),
                              has_tab_behind(line, rest)});
        }
    }

    /// Whether most lines have commas or semicolons and fall apart into rows by these alone.
    bool only_separators() const {
        std::size_t num_lines = 0, num_with = 0, num_rows_without = 0, num_rows_with = 0;
        for (const Line& line : lines_) {
            if (is_text_comment(line.text)) continue;
            ++num_lines;
            num_rows_without += is_row(kinds_of(line.text, false));
            if (line.text.find_first_of(",;") == std::string_view::npos) continue;
            ++num_with;
            num_rows_with +=
                is_row(kinds_of(line.text, true)) && !has_numbers_in_a_field(line.text);
        }
        return num_with * 2 > num_lines && num_rows_with * 2 > num_rows_without;
    }

    /// The header is the first line that names x, y and z; else the last one before the rows, if it
    /// is of words. What is in front of the rows and no header is a bad row.
    void add(const Line& line) {
        const bool is_comment = is_text_comment(line.text);
        if (rows_.empty() && names_coordinates(header_names(line.text))) {
            headers_.emplace_back(line.text);
            if (!is_comment && num_bad_ == 0) layout_.begin = line.next;
            has_header_line_ = has_header_line_ || !is_comment;
            return;
        }
        if (is_comment) return;
        LineKinds kinds = kinds_of(line.text, layout_.syntax.only_separators);
        if (line.has_tab_behind) kinds.push_back(FieldKind::kEmpty);
        if (is_row(kinds)) {
            if (rows_.empty()) first_row_ = line.text;
            num_decimal_commas_ += has_decimal_commas(line.text);
            rows_.push_back(std::move(kinds));
        } else if (rows_.empty() && num_bad_ == 0 && is_above_rows(kinds)) {
            if (!has_header_line_) layout_.header = line.text;
            layout_.begin = line.next;
            ++num_headers_;
        } else {
            ++num_bad_;
        }
    }

    /// Behind a header only units of words are skipped; elsewhere anything with a word in it.
    bool is_above_rows(const LineKinds& kinds) const {
        return has_header_line_ ? has_no(FieldKind::kNumber, kinds)
                                : !has_no(FieldKind::kWord, kinds);
    }

    [[noreturn]] void fail_decimal_commas() const {
        const auto byte = static_cast<std::size_t>(first_row_.data() - text_.data());
        fail(ErrorCode::kInvalidInput,
             "{}:{}: numbers with decimal commas; decimal points are wanted (for example by: sed "
             "'s/,/./g')",
             path_, line_of_byte(text_, byte, line_end_));
    }

    /// As most rows have them. Returns whether enough of them are numbers.
    bool count_columns() {
        std::map<std::size_t, std::size_t> num_rows;
        for (const LineKinds& row : rows_) ++num_rows[row.size()];
        const auto most =
            std::max_element(num_rows.begin(), num_rows.end(),
                             [](const auto& a, const auto& b) { return a.second < b.second; });
        std::size_t n = most->first;
        const auto count = [&](std::size_t column, FieldKind kind) {
            return static_cast<std::size_t>(
                std::count_if(rows_.begin(), rows_.end(), [&](const LineKinds& row) {
                    return row.size() == most->first && row[column] == kind;
                }));
        };
        for (std::size_t k = 0; k < n; ++k)
            layout_.is_number.push_back(count(k, FieldKind::kNumber) > count(k, FieldKind::kWord));
        find_names(n);
        // Separators at the ends of lines, with nothing behind them and no name for it
        if (layout_.names.empty() && count(n - 1, FieldKind::kEmpty) == most->second) {
            layout_.is_number.pop_back();
            find_names(--n);
        }
        layout_.num_columns = n;
        return static_cast<std::size_t>(std::count(layout_.is_number.begin(),
                                                   layout_.is_number.end(), true)) >= kLeastNumbers;
    }

    void find_names(std::size_t num_columns) {
        if (!headers_.empty()) layout_.header = headers_[0];
        for (const std::string& header : headers_) {
            std::vector<std::string> names = header_names(header);
            if (names.size() != num_columns) continue;
            layout_.header = header;
            layout_.names = std::move(names);
            return;
        }
    }

    std::string_view text_;
    char line_end_;
    const std::string& path_;
    TextLayout layout_;
    std::vector<Line> lines_;  ///< neither blank nor counts
    std::vector<LineKinds> rows_;
    std::vector<std::string> headers_;  ///< lines that name x, y and z
    bool has_header_line_ = false;      ///< one of them that is no comment
    std::string_view first_row_;
    std::size_t num_headers_ = 0, num_bad_ = 0, num_decimal_commas_ = 0;
};

}  // namespace

std::optional<TextLayout> find_text_layout(std::string_view text, const std::string& path) {
    return Sample(text, line_end_of(text), path).layout();
}

ColumnStats::ColumnStats(std::size_t num_columns) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    Column none;
    none.min = kInfinity;
    none.max = -kInfinity;
    columns_.assign(num_columns, none);
}

namespace {

bool has_no_fraction(double v) {
    constexpr double kAllWhole =
        4503599627370496.0;  // 2^52: doubles have no fractions from here on
    return !(std::abs(v) < kAllWhole) || v == static_cast<double>(static_cast<std::int64_t>(v));
}

}  // namespace

void ColumnStats::add(std::span<const std::vector<double>> columns,
                      std::span<const std::uint8_t> has_point) {
    const std::vector<double>& first = columns[0];
    for (std::size_t k = 0; k < columns.size(); ++k) {
        Column& known = columns_[k];
        known.has_point = known.has_point || has_point[k] != 0;
        bool whole = known.is_whole;
        double low = known.min, high = known.max;
        for (std::size_t i = 0; i < first.size(); ++i) {
            const double v = columns[k][i];
            if (std::isnan(first[i]) || std::isnan(v)) continue;
            whole = whole && has_no_fraction(v);
            low = std::min(low, v);
            high = std::max(high, v);
        }
        known.is_whole = whole, known.min = low, known.max = high;
        if (!has_triple(k)) continue;
        for (std::size_t i = 0; i < first.size() && known.is_unit; ++i) {
            if (std::isnan(first[i])) continue;
            const Vec3d v{columns[k][i], columns[k + 1][i], columns[k + 2][i]};
            const double length = squared_length(v);
            if (length == 0.0) continue;
            known.is_zero = false;
            known.is_unit = std::abs(length - 1.0) < 2.0 * kUnitTolerance;
        }
    }
}

void ColumnStats::add(const ColumnStats& other) {
    for (std::size_t k = 0; k < columns_.size(); ++k) {
        Column& known = columns_[k];
        const Column& more = other.columns_[k];
        known.is_whole = known.is_whole && more.is_whole;
        known.has_point = known.has_point || more.has_point;
        known.min = std::min(known.min, more.min);
        known.max = std::max(known.max, more.max);
        known.is_unit = known.is_unit && more.is_unit;
        known.is_zero = known.is_zero && more.is_zero;
    }
}

bool ColumnStats::is_color(std::size_t first) const {
    if (!has_triple(first)) return false;
    bool is_whole = true;
    double min = 0.0, max = 0.0;
    for (std::size_t k = first; k < first + 3; ++k) {
        if (columns_[k].min > columns_[k].max) return false;  // no numbers
        is_whole = is_whole && columns_[k].is_whole;
        min = std::min(min, columns_[k].min);
        max = std::max(max, columns_[k].max);
    }
    return min >= 0.0 && max <= (is_whole ? 255.0 : 1.0);
}

bool ColumnStats::is_normal(std::size_t first) const {
    return has_triple(first) && columns_[first].is_unit && !columns_[first].is_zero;
}

bool ColumnStats::is_class_color(std::size_t first) const {
    if (!is_normal(first)) return false;
    bool is_one = true;  // direction only, as of a plane
    for (std::size_t k = first; k < first + 3; ++k) {
        if (!is_whole_unit(k)) return false;
        is_one = is_one && is_constant(k);
    }
    return !is_one;
}

std::vector<std::string> names_by_content(const ColumnStats& stats, std::size_t num_columns,
                                          const TextHints& hints) {
    std::vector<std::string> names = {"x", "y", "z"};
    const auto is_triple = [&](std::size_t k) { return stats.is_normal(k) || stats.is_color(k); };
    // One column more than threes: before or behind them.
    const bool has_odd = num_columns > 3 && num_columns % 3 == 1;
    const bool is_behind =
        is_triple(3) &&
        (!is_triple(4) || (!hints.has_intensity_first && stats.is_constant(num_columns - 1)));
    if (has_odd && !is_behind) names.emplace_back("intensity");
    bool has_normals = false, has_colors = false;
    while (names.size() < num_columns) {
        const std::size_t k = names.size();
        const bool is_color = !hints.has_normals && !has_colors && stats.is_class_color(k);
        if (!has_normals && !is_color && stats.is_normal(k)) {
            names.insert(names.end(), {"nx", "ny", "nz"});
            has_normals = true;
        } else if (!has_colors && stats.is_color(k)) {
            names.insert(names.end(), {"red", "green", "blue"});
            has_colors = true;
        } else {
            names.push_back(fmt::format("column_{}", k + 1));
        }
    }
    return names;
}

std::vector<std::string> parse_columns(std::string_view text) {
    std::vector<std::string> names;
    while (true) {
        const std::size_t end = std::min(text.find(','), text.size());
        const std::string_view name = trimmed(text.substr(0, end));
        const bool is_twice = name != "-" && has_name(names, lower(name));
        if (name.empty() || is_twice)
            fail(ErrorCode::kInvalidOption,
                 "columns: '{}' {}; expected names like x,y,z,red,green,blue,-,intensity", name,
                 is_twice ? "is named twice" : "is no name");
        names.emplace_back(name == "-" ? "" : name);
        if (end == text.size()) break;
        text.remove_prefix(end + 1);
    }
    if (!names_coordinates(names))
        fail(ErrorCode::kInvalidOption,
             "columns: x, y and z must be among them, like x,y,z,red,green,blue,-,intensity");
    return names;
}

}  // namespace pointbake
