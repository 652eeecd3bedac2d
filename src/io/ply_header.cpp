// Based on [Turk94], "The PLY Polygon File Format", and on what writers make of it: sized type
// names, any line end, tabs, obj_info, stray lines before the first element.
#include "io/ply_header.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

#include "core/message.h"

namespace pointbake {
namespace {

// No writer's header comes near; garbage is not searched for its end any longer.
constexpr std::size_t kMaxHeaderBytes = std::size_t{1} << 22;

constexpr std::array<std::pair<std::string_view, NumberType>, 16> kTypeNames{{
    {"char", NumberType::kInt8},
    {"int8", NumberType::kInt8},
    {"uchar", NumberType::kUint8},
    {"uint8", NumberType::kUint8},
    {"short", NumberType::kInt16},
    {"int16", NumberType::kInt16},
    {"ushort", NumberType::kUint16},
    {"uint16", NumberType::kUint16},
    {"int", NumberType::kInt32},
    {"int32", NumberType::kInt32},
    {"uint", NumberType::kUint32},
    {"uint32", NumberType::kUint32},
    {"float", NumberType::kFloat32},
    {"float32", NumberType::kFloat32},
    {"double", NumberType::kFloat64},
    {"float64", NumberType::kFloat64},
}};

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }
bool is_line_end(char c) { return c == '\n' || c == '\r'; }

std::string_view as_text(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Takes the first word off `line`.
std::string_view take_word(std::string_view& line) {
    std::size_t begin = 0;
    while (begin < line.size() && is_blank(line[begin])) ++begin;
    std::size_t end = begin;
    while (end < line.size() && !is_blank(line[end])) ++end;
    const std::string_view word = line.substr(begin, end - begin);
    line.remove_prefix(end);
    return word;
}

std::string_view trimmed(std::string_view text) {
    while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
    while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
    return text;
}

/// For messages: short, and printable whatever the file holds.
std::string quoted(std::string_view text) {
    std::string out = "'";
    for (char c : text.substr(0, 40)) out += c >= ' ' && c <= '~' ? c : '?';
    return out + (text.size() > 40 ? "...'" : "'");
}

/// A name that several of these have, unless it is empty.
template <class Named>
std::string_view name_of_several(const std::vector<Named>& all) {
    std::vector<std::string_view> names;
    for (const Named& named : all) names.push_back(named.name);
    std::ranges::sort(names);
    const auto twice = std::ranges::adjacent_find(names);
    return twice == names.end() ? std::string_view() : *twice;
}

class HeaderReader {
 public:
    HeaderReader(std::string_view text, const std::string& path) : text_(text), path_(path) {}

    PlyHeader read() {
        skip_to_magic();
        while (!read_line()) {
        }
        if (!has_format_)
            fail_here(
                "the header has no 'format' line; 'format ascii 1.0', 'format "
                "binary_little_endian 1.0' or 'format binary_big_endian 1.0' is wanted");
        check_names();
        header_.num_bytes = position_;
        return std::move(header_);
    }

 private:
    template <class... Args>
    [[noreturn]] void fail_here(fmt::format_string<Args...> format, Args&&... args) const {
        fail(ErrorCode::kInvalidInput, "{}:{}: {}", path_, header_.num_lines,
             fmt::format(format, std::forward<Args>(args)...));
    }

    /// Which of two is meant nobody knows.
    void check_names() const {
        if (const std::string_view name = name_of_several(header_.elements); !name.empty())
            fail_here("there are several elements {}; one is wanted", quoted(name));
        for (const PlyElement& element : header_.elements)
            if (const std::string_view name = name_of_several(element.properties); !name.empty())
                fail_here("element {} has several properties {}; one is wanted",
                          quoted(element.name), quoted(name));
    }

    void skip_to_magic() {
        while (position_ < text_.size() &&
               (is_blank(text_[position_]) || is_line_end(text_[position_]))) {
            if (text_[position_] == '\n') ++header_.num_lines;
            ++position_;
        }
        const std::size_t end = text_.find_first_of("\r\n", position_);
        if (end != std::string_view::npos && text_[end] == '\r' && text_.substr(end, 2) != "\r\n")
            header_.line_end = '\r';
        next_line();
    }

    /// The next line without its end. After CR, LF is part of the line end unless all lines end in
    /// CR alone: then it is the first byte of the data.
    std::string_view next_line() {
        const std::size_t end = text_.find_first_of("\r\n", position_);
        ++header_.num_lines;
        if (end == std::string_view::npos) {
            if (text_.size() >= kMaxHeaderBytes)
                fail_here("no 'end_header' in the first {} bytes", kMaxHeaderBytes);
            // An empty header may end without a line end.
            const std::string_view rest = text_.substr(position_);
            if (trimmed(rest) != "end_header")
                fail_here("the file ends inside the header: no 'end_header' line");
            position_ = text_.size();
            return rest;
        }
        const std::string_view line = text_.substr(position_, end - position_);
        position_ = end + 1;
        if (text_[end] == '\r' && header_.line_end == '\n' && position_ < text_.size() &&
            text_[position_] == '\n')
            ++position_;
        return line;
    }

    /// Returns whether this was the last line.
    bool read_line() {
        std::string_view line = next_line();
        const std::string_view whole = line;
        const std::string_view word = take_word(line);
        if (word == "end_header") return true;
        if (word.empty() || word == "obj_info") return false;
        if (word == "comment") {
            header_.comments.emplace_back(trimmed(line));
        } else if (word == "format") {
            read_format(line);
        } else if (word == "element") {
            read_element(line);
        } else if (word == "property") {
            read_property(line);
        } else {
            tolerate(whole);
        }
        return false;
    }

    void read_format(std::string_view line) {
        const std::string_view word = take_word(line);
        has_format_ = true;
        for (PlyFormat format :
             {PlyFormat::kAscii, PlyFormat::kLittleEndian, PlyFormat::kBigEndian}) {
            if (word != to_string(format)) continue;
            header_.format = format;
            return;
        }
        fail_here(
            "unknown format {}; 'ascii', 'binary_little_endian' and 'binary_big_endian' are read",
            quoted(word));
    }

    void read_element(std::string_view line) {
        PlyElement element;
        element.name = take_word(line);
        const std::string_view count = take_word(line);
        const auto [end, error] =
            std::from_chars(count.data(), count.data() + count.size(), element.count);
        if (element.name.empty() || count.empty() || error != std::errc{} ||
            end != count.data() + count.size())
            fail_here("{} is no number of rows; 'element NAME COUNT' is wanted", quoted(count));
        header_.elements.push_back(std::move(element));
    }

    NumberType read_type(std::string_view word) const {
        for (const auto& [name, type] : kTypeNames)
            if (name == word) return type;
        fail_here(
            "unknown type {}; char, uchar, short, ushort, int, uint, float, double and int8, "
            "uint8, int16, uint16, int32, uint32, float32, float64 are read",
            quoted(word));
    }

    void read_property(std::string_view line) {
        if (header_.elements.empty()) fail_here("'property' before the first 'element'");
        PlyProperty property;
        std::string_view word = take_word(line);
        if (word == "list") {
            property.count_type = read_type(take_word(line));
            if (is_float(*property.count_type)) fail_here("a list's count must be an integer type");
            word = take_word(line);
        }
        property.type = read_type(word);
        property.name = trimmed(line);
        if (property.name.empty())
            fail_here("a property without a name; 'property TYPE NAME' is wanted");
        header_.elements.back().properties.push_back(std::move(property));
    }

    /// Stray lines before the first element cannot shift the data; later ones might be a misspelt
    /// element or property.
    void tolerate(std::string_view line) {
        const bool is_text = std::all_of(
            line.begin(), line.end(), [](char c) { return is_blank(c) || (c >= ' ' && c <= '~'); });
        if (!header_.elements.empty() || !is_text)
            fail_here(
                "{} is no header line; 'format', 'comment', 'obj_info', 'element', 'property' or "
                "'end_header' is wanted",
                quoted(line));
        if (header_.notes.empty()) header_.notes.push_back("unknown header lines ignored");
    }

    std::string_view text_;
    const std::string& path_;
    std::size_t position_ = 0;
    bool has_format_ = false;
    PlyHeader header_;
};

}  // namespace

std::string_view to_string(PlyFormat format) {
    switch (format) {
        case PlyFormat::kAscii:
            return "ascii";
        case PlyFormat::kLittleEndian:
            return "binary_little_endian";
        case PlyFormat::kBigEndian:
            return "binary_big_endian";
    }
    return "";
}

bool PlyElement::has_lists() const {
    return std::any_of(properties.begin(), properties.end(),
                       [](const PlyProperty& p) { return p.is_list(); });
}

std::size_t PlyElement::min_row_bytes() const {
    std::size_t sum = 0;
    for (const PlyProperty& p : properties) sum += size_of(p.count_type.value_or(p.type));
    return sum;
}

std::optional<std::size_t> PlyElement::find(std::string_view property) const {
    for (std::size_t i = 0; i < properties.size(); ++i)
        if (properties[i].name == property) return i;
    return std::nullopt;
}

std::optional<std::size_t> PlyHeader::find(std::string_view element) const {
    for (std::size_t i = 0; i < elements.size(); ++i)
        if (elements[i].name == element) return i;
    return std::nullopt;
}

bool is_ply(std::span<const std::byte> bytes) {
    const std::string_view text = as_text(bytes.first(std::min<std::size_t>(bytes.size(), 4096)));
    const std::size_t begin = text.find_first_not_of(" \t\v\f\r\n");
    if (begin == std::string_view::npos || text.substr(begin, 3) != "ply") return false;
    return begin + 3 == text.size() || is_blank(text[begin + 3]) || is_line_end(text[begin + 3]);
}

PlyHeader read_ply_header(std::span<const std::byte> bytes, const std::string& path) {
    const std::string_view text = as_text(bytes);
    return HeaderReader(text.substr(0, kMaxHeaderBytes), path).read();
}

}  // namespace pointbake
