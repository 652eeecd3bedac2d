#include "io/text_layout.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "core/message.h"
#include "io/text_numbers.h"
#include "pointbake/vec.h"

namespace pointbake {
namespace {

constexpr std::size_t kSampleBytes = std::size_t{1} << 16;
constexpr std::size_t kLeastNumbers = 3;
constexpr std::size_t kMostHeaderLines = 16;
// Normals are often written with three digits.
constexpr double kUnitTolerance = 0.02;
constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";

std::string lower(std::string_view text) {
    std::string out(text);
    for (char& c : out)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return out;
}

std::string_view trimmed(std::string_view text, std::string_view what = " \t\r\"") {
    const std::size_t begin = text.find_first_not_of(what);
    if (begin == std::string_view::npos) return {};
    return text.substr(begin, text.find_last_not_of(what) - begin + 1);
}

/// Which fields of a line are numbers.
std::vector<bool> number_mask(std::string_view line) {
    std::vector<bool> mask;
    for (Fields fields(line); !fields.at_end();) {
        NumberReader reader(fields.word());
        double value = 0.0;
        mask.push_back(reader.next(value) && reader.at_end());
    }
    return mask;
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

/// The words of a header line; units in brackets are left out. Blanks separate only where nothing
/// else does.
std::vector<std::string> header_names(std::string_view line) {
    line = trimmed(line, " \t\r#/");
    const bool has_separators = line.find_first_of(",;\t") != std::string_view::npos;
    const std::string_view separators = has_separators ? ",;\t" : " ";
    std::vector<std::string> names;
    while (!line.empty()) {
        const std::size_t end = std::min(line.find_first_of(separators), line.size());
        std::string_view name = trimmed(line.substr(0, end));
        name = trimmed(name.substr(0, name.find_first_of("[(")));
        if (!name.empty() || has_separators) names.emplace_back(name);
        line.remove_prefix(std::min(end + 1, line.size()));
    }
    return names;
}

bool has_name(const std::vector<std::string>& names, std::string_view wanted) {
    return std::any_of(names.begin(), names.end(),
                       [&](const std::string& name) { return lower(name) == wanted; });
}

bool names_coordinates(const std::vector<std::string>& names) {
    return has_name(names, "x") && has_name(names, "y") && has_name(names, "z");
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

/// The first lines of a text, sorted into headers and rows.
class Sample {
 public:
    Sample(std::string_view text, char line_end, const std::string& path)
        : text_(text), line_end_(line_end), path_(path) {}

    std::optional<TextLayout> layout(std::size_t begin) {
        layout_.line_end = line_end_;
        layout_.begin = begin;
        std::string_view rest = text_.substr(begin, kSampleBytes);
        if (rest.find('\0') != std::string_view::npos) return std::nullopt;
        // The last line may be cut.
        if (text_.size() - begin > kSampleBytes) {
            const std::size_t end = rest.rfind(line_end_);
            if (end == std::string_view::npos) return std::nullopt;
            rest = rest.substr(0, end + 1);
        }
        while (!rest.empty()) {
            const std::string_view line = take_line(rest, line_end_);
            add(line, static_cast<std::size_t>(rest.data() - text_.data()));
        }
        if (masks_.empty() || num_headers_ > kMostHeaderLines || num_bad_ > masks_.size())
            return std::nullopt;
        if (num_decimal_commas_ * 2 > masks_.size()) fail_decimal_commas();
        return count_columns() ? std::optional(std::move(layout_)) : std::nullopt;
    }

 private:
    void add(std::string_view line, std::size_t next_line) {
        if (line.empty() || is_text_count(line)) return;
        if (is_text_comment(line)) {
            if (masks_.empty() && layout_.header.empty() && names_coordinates(header_names(line)))
                layout_.header = line;
            return;
        }
        std::vector<bool> mask = number_mask(line);
        if (static_cast<std::size_t>(std::count(mask.begin(), mask.end(), true)) >= kLeastNumbers) {
            if (masks_.empty()) first_row_ = line;
            num_decimal_commas_ += has_decimal_commas(line);
            masks_.push_back(std::move(mask));
        } else if (masks_.empty()) {
            layout_.header = line;
            layout_.begin = next_line;
            ++num_headers_;
        } else {
            ++num_bad_;
        }
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
        for (const std::vector<bool>& mask : masks_) ++num_rows[mask.size()];
        const auto most =
            std::max_element(num_rows.begin(), num_rows.end(),
                             [](const auto& a, const auto& b) { return a.second < b.second; });
        const std::size_t n = layout_.num_columns = most->first;
        for (std::size_t k = 0; k < n; ++k) {
            const auto num_numbers = std::count_if(
                masks_.begin(), masks_.end(),
                [&](const std::vector<bool>& mask) { return mask.size() == n && mask[k]; });
            layout_.is_number.push_back(static_cast<std::size_t>(num_numbers) * 2 > most->second);
        }
        std::vector<std::string> names = header_names(layout_.header);
        translate_coordinates(names);
        if (names.size() == n && names_coordinates(names)) layout_.names = std::move(names);
        return static_cast<std::size_t>(std::count(layout_.is_number.begin(),
                                                   layout_.is_number.end(), true)) >= kLeastNumbers;
    }

    std::string_view text_;
    char line_end_;
    const std::string& path_;
    TextLayout layout_;
    std::vector<std::vector<bool>> masks_;  ///< of the rows
    std::string_view first_row_;
    std::size_t num_headers_ = 0, num_bad_ = 0, num_decimal_commas_ = 0;
};

}  // namespace

std::optional<TextLayout> find_text_layout(std::string_view text, const std::string& path) {
    const std::size_t begin = text.starts_with(kByteOrderMark) ? kByteOrderMark.size() : 0;
    return Sample(text, line_end_of(text), path).layout(begin);
}

ColumnStats::ColumnStats(std::size_t num_columns) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    Column none;
    none.min = kInfinity;
    none.max = -kInfinity;
    columns_.assign(num_columns, none);
}

void ColumnStats::add(std::span<const std::vector<double>> columns) {
    const std::vector<double>& first = columns[0];
    for (std::size_t k = 0; k < columns.size(); ++k) {
        Column& known = columns_[k];
        for (std::size_t i = 0; i < first.size(); ++i) {
            const double v = columns[k][i];
            if (std::isnan(first[i]) || std::isnan(v)) continue;
            known.is_whole = known.is_whole && v == std::floor(v);
            known.min = std::min(known.min, v);
            known.max = std::max(known.max, v);
        }
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
        is_whole = is_whole && columns_[k].is_whole;
        min = std::min(min, columns_[k].min);
        max = std::max(max, columns_[k].max);
    }
    return min >= 0.0 && max <= (is_whole ? 255.0 : 1.0);
}

bool ColumnStats::is_normal(std::size_t first) const {
    return has_triple(first) && columns_[first].is_unit && !columns_[first].is_zero;
}

std::vector<std::string> names_by_content(const ColumnStats& stats, std::size_t num_columns,
                                          bool intensity_first) {
    std::vector<std::string> names = {"x", "y", "z"};
    const auto is_triple = [&](std::size_t k) { return stats.is_normal(k) || stats.is_color(k); };
    // One column more than threes: before or behind them.
    const bool has_odd = num_columns > 3 && num_columns % 3 == 1;
    const bool is_behind =
        is_triple(3) && (!is_triple(4) || (!intensity_first && stats.is_constant(num_columns - 1)));
    if (has_odd && !is_behind) names.emplace_back("intensity");
    bool has_normals = false, has_colors = false;
    while (names.size() < num_columns) {
        const std::size_t k = names.size();
        if (!has_normals && stats.is_normal(k)) {
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
