// After the description of the format at pointclouds.org, and what writers make of it: COLUMNS for
// FIELDS (0.5), no COUNT, no VIEWPOINT (0.6), no magic comment.
#include "io/pcd_header.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>

#include "core/message.h"
#include "io/text_numbers.h"
#include "io/text_rows.h"

namespace pointbake {
namespace {

constexpr std::size_t kMaxHeaderBytes = std::size_t{1} << 20;  // no writer's comes near
constexpr std::size_t kMaxFields = 4096;

std::vector<std::string_view> words_of(std::string_view line) {
    std::vector<std::string_view> words;
    for (std::size_t at = 0; at < line.size();) {
        const std::size_t begin = line.find_first_not_of(" \t\r", at);
        if (begin == std::string_view::npos) break;
        at = std::min(line.find_first_of(" \t\r", begin), line.size());
        words.push_back(line.substr(begin, at - begin));
    }
    return words;
}

std::optional<NumberType> type_of(char kind, std::size_t size) {
    using enum NumberType;
    struct Known {
        char kind;
        std::size_t size;
        NumberType type;
    };
    constexpr std::array<Known, 10> kTypes{{{'I', 1, kInt8},
                                            {'I', 2, kInt16},
                                            {'I', 4, kInt32},
                                            {'I', 8, kInt64},
                                            {'U', 1, kUint8},
                                            {'U', 2, kUint16},
                                            {'U', 4, kUint32},
                                            {'U', 8, kUint64},
                                            {'F', 4, kFloat32},
                                            {'F', 8, kFloat64}}};
    for (const Known& known : kTypes)
        if (known.kind == kind && known.size == size) return known.type;
    return std::nullopt;
}

class HeaderReader {
 public:
    HeaderReader(std::string_view text, const std::string& path) : text_(text), path_(path) {}

    PcdHeader read() {
        std::string_view rest = text_.substr(0, kMaxHeaderBytes);
        while (!rest.empty()) {
            const std::string_view line = take_line(rest, '\n');
            ++line_;
            if (line.empty() || line.front() == '#') continue;
            words_ = words_of(line);
            if (words_[0] == "DATA") {
                header_.num_bytes = static_cast<std::size_t>(rest.data() - text_.data());
                finish();
                return std::move(header_);
            }
            read_line();
        }
        fail(ErrorCode::kInvalidInput,
             "{}: the header has no 'DATA' line with ascii, binary or binary_compressed", path_);
    }

 private:
    void read_line() {
        const std::string_view key = words_[0];
        const std::vector<std::string_view> values(words_.begin() + 1, words_.end());
        if (values.size() > kMaxFields) fail_here("has more than {} values", kMaxFields);
        if (key == "FIELDS" || key == "COLUMNS")
            names_ = values;
        else if (key == "SIZE")
            for (const std::string_view v : values) sizes_.push_back(whole_number(v));
        else if (key == "TYPE")
            kinds_ = values;
        else if (key == "COUNT")
            for (const std::string_view v : values) counts_.push_back(whole_number(v));
        else if (key == "WIDTH")
            header_.width = one_number();
        else if (key == "HEIGHT")
            header_.height = one_number();
        else if (key == "POINTS")
            points_ = one_number();
        else if (key == "VIEWPOINT")
            read_viewpoint(values);
        else if (key != "VERSION")
            fail_here("is no line of a PCD header");
    }

    template <class... Args>
    [[noreturn]] void fail_here(fmt::format_string<Args...> problem, Args&&... args) const {
        constexpr std::size_t kLongest = 60;
        const std::string shown(words_[0].substr(0, kLongest));
        fail(ErrorCode::kInvalidInput, "{}:{}: '{}' {}", path_, line_, shown,
             fmt::format(problem, std::forward<Args>(args)...));
    }

    std::uint64_t whole_number(std::string_view word) const {
        std::uint64_t value = 0;
        const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), value);
        if (error != std::errc{} || stop != word.data() + word.size())
            fail_here("wants whole numbers, not '{}'", word.substr(0, 40));
        return value;
    }

    std::uint64_t one_number() const {
        if (words_.size() != 2) fail_here("wants one number");
        return whole_number(words_[1]);
    }

    void read_viewpoint(const std::vector<std::string_view>& values) {
        Vec3d position;
        for (std::size_t k = 0; k < 3; ++k)
            if (k >= values.size() || !NumberReader(values[k]).next(position[k]) ||
                !is_finite(position))
                fail_here("wants a position and a quaternion: seven numbers");
        if (!(position == Vec3d{})) header_.viewpoint = position;
    }

    void finish() {
        if (words_.size() != 2) fail_here("wants ascii, binary or binary_compressed");
        if (words_[1] == "ascii")
            header_.data = PcdData::kAscii;
        else if (words_[1] == "binary")
            header_.data = PcdData::kBinary;
        else if (words_[1] == "binary_compressed")
            header_.data = PcdData::kCompressed;
        else
            fail_here("wants ascii, binary or binary_compressed, not '{}'",
                      words_[1].substr(0, 40));
        lay_out();
        count_points();
    }

    void lay_out() {
        if (names_.empty())
            fail(ErrorCode::kInvalidInput, "{}: the header has no 'FIELDS' line", path_);
        check_size("SIZE", sizes_.size());
        check_size("TYPE", kinds_.size());
        check_size("COUNT", counts_.size());
        for (std::size_t i = 0; i < names_.size(); ++i) {
            PcdField field;
            field.name = names_[i];
            const std::uint64_t size = sizes_.empty() ? 4 : sizes_[i];
            const std::string_view kind = kinds_.empty() ? "F" : kinds_[i];
            const std::optional<NumberType> type =
                kind.size() == 1 ? type_of(kind[0], size) : std::nullopt;
            if (!type)
                fail(ErrorCode::kInvalidInput,
                     "{}: field '{}' has the type {} and the size {}; I or U of 1, 2, 4 or 8 "
                     "bytes or F of 4 or 8 is wanted",
                     path_, field.name, kind.substr(0, 40), size);
            field.type = *type;
            field.count = counts_.empty() ? 1 : counts_[i];
            field.offset = header_.row_bytes;
            if (field.count > std::numeric_limits<std::uint32_t>::max())
                fail(ErrorCode::kInvalidInput, "{}: field '{}' has {} values per point", path_,
                     field.name, field.count);
            header_.row_bytes += field.num_bytes();
            header_.row_values += field.count;
            header_.fields.push_back(std::move(field));
        }
    }

    void check_size(std::string_view key, std::size_t size) const {
        if (size != 0 && size != names_.size())
            fail(ErrorCode::kInvalidInput, "{}: the header has {} FIELDS, but {} values of {}",
                 path_, names_.size(), size, key);
    }

    void count_points() {
        constexpr std::uint64_t kMost = std::numeric_limits<std::uint64_t>::max();
        const bool is_whole = header_.height == 0 || header_.width <= kMost / header_.height;
        const std::uint64_t area = is_whole ? header_.width * header_.height : kMost;
        header_.num_points = points_.value_or(area);
        if (points_ && area != 0 && area != *points_)
            header_.notes.push_back(
                fmt::format("POINTS {} is not WIDTH {} x HEIGHT {}: {} are read", *points_,
                            header_.width, header_.height, *points_));
    }

    std::string_view text_;
    const std::string& path_;
    std::size_t line_ = 0;
    std::vector<std::string_view> words_, names_, kinds_;
    std::vector<std::uint64_t> sizes_, counts_;
    std::optional<std::uint64_t> points_;
    PcdHeader header_;
};

}  // namespace

std::string_view to_string(PcdData data) {
    constexpr std::array<std::string_view, 3> kWords{"ascii", "binary", "binary_compressed"};
    return kWords[static_cast<std::size_t>(data)];
}

PcdHeader read_pcd_header(std::string_view text, const std::string& path) {
    return HeaderReader(text, path).read();
}

}  // namespace pointbake
