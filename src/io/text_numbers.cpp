// std::from_chars does not depend on the locale and rounds correctly.
#include "io/text_numbers.h"

#include <charconv>
#include <cstring>
#include <limits>

namespace pointbake {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f'; }

void skip_blanks(std::string_view& text) {
    std::size_t n = 0;
    while (n < text.size() && is_blank(text[n])) ++n;
    text.remove_prefix(n);
}

bool begins_with_word(std::string_view line, std::string_view word) {
    return line.substr(0, word.size()) == word &&
           (line.size() == word.size() || is_blank(line[word.size()]));
}

/// What from_chars leaves alone because a double cannot hold it: too small or too large. That is
/// told by the exponent, and without one by the digits in front of the point.
double out_of_range(std::string_view word) {
    const std::size_t exponent = word.find_first_of("eE");
    const bool is_small = exponent != word.npos ? word.substr(exponent).starts_with("e-") ||
                                                      word.substr(exponent).starts_with("E-")
                                                : word.find_first_of("123456789") > word.find('.');
    const double size = is_small ? 0.0 : std::numeric_limits<double>::infinity();
    return word.front() == '-' ? -size : size;
}

}  // namespace

std::vector<std::string_view> cut_text(std::string_view text, char line_end) {
    constexpr std::size_t kBytes = std::size_t{1} << 18;
    std::vector<std::string_view> parts;
    while (!text.empty()) {
        std::size_t size = text.size();
        if (size > kBytes) {
            const void* end = std::memchr(text.data() + kBytes, line_end, size - kBytes);
            if (end != nullptr)
                size = static_cast<std::size_t>(static_cast<const char*>(end) - text.data()) + 1;
        }
        parts.push_back(text.substr(0, size));
        text.remove_prefix(size);
    }
    return parts;
}

bool TextLines::next() {
    while (!rest_.empty()) {
        const void* end = std::memchr(rest_.data(), line_end_, rest_.size());
        const std::size_t size =
            end == nullptr ? rest_.size()
                           : static_cast<std::size_t>(static_cast<const char*>(end) - rest_.data());
        line_ = rest_.substr(0, size);
        rest_.remove_prefix(end == nullptr ? size : size + 1);
        skip_blanks(line_);
        if (!line_.empty() && !begins_with_word(line_, "comment") &&
            !begins_with_word(line_, "obj_info"))
            return true;
    }
    return false;
}

bool NumberReader::next(double& value) {
    skip_blanks(rest_);
    if (rest_.empty()) {
        problem_ = "too few values";
        return false;
    }
    const char* begin = rest_.data();
    const char* const end = begin + rest_.size();
    const ShortNumber number = read_short_number(begin, end);
    if (number.end != nullptr && (number.end == end || is_blank(*number.end))) {
        value = number.value;
        rest_.remove_prefix(static_cast<std::size_t>(number.end - begin));
        return true;
    }
    if (*begin == '+' && end - begin > 1 && begin[1] != '-') ++begin;
    const auto [stop, error] = std::from_chars(begin, end, value);
    if (error == std::errc::result_out_of_range)
        value = out_of_range({begin, static_cast<std::size_t>(stop - begin)});
    if (error != std::errc::invalid_argument && (stop == end || is_blank(*stop))) {
        rest_.remove_prefix(static_cast<std::size_t>(stop - rest_.data()));
        return true;
    }
    // "1.#IND", "-1.#QNAN", "1.#INF": no finite number, whichever
    if (stop != end && *stop == '#' && error == std::errc{}) {
        value = std::numeric_limits<double>::quiet_NaN();
        return skip();
    }
    problem_ = "text that is no number";
    return false;
}

bool NumberReader::skip() {
    skip_blanks(rest_);
    if (rest_.empty()) {
        problem_ = "too few values";
        return false;
    }
    std::size_t n = 0;
    while (n < rest_.size() && !is_blank(rest_[n])) ++n;
    rest_.remove_prefix(n);
    return true;
}

bool NumberReader::at_end() {
    skip_blanks(rest_);
    return rest_.empty();
}

}  // namespace pointbake
