// Lines and numbers of text files.
#pragma once

#include <array>
#include <cstdint>
#include <iterator>
#include <string_view>
#include <vector>

namespace pointbake {

/// A text in pieces of whole lines, about a quarter megabyte each, for several threads.
std::vector<std::string_view> cut_text(std::string_view text, char line_end);

/// The lines of a text that are neither blank nor begin with "comment" or "obj_info".
class TextLines {
 public:
    TextLines(std::string_view text, char line_end) : rest_(text), line_end_(line_end) {}

    bool next();
    std::string_view line() const { return line_; }  ///< without its end and leading blanks

 private:
    std::string_view rest_;
    std::string_view line_;
    char line_end_;
};

struct ShortNumber {
    const char* end = nullptr;  ///< behind it; null = there is none
    double value = 0.0;
    bool has_point = false;  ///< and digits behind it
};

inline constexpr std::array<double, 16> kPowersOfTen{1e0, 1e1, 1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                                     1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15};

/// A number of at most 15 digits without an exponent: the same bits as std::from_chars gives,
/// sooner.
// Both the digits as a whole number and the power of ten are doubles, and their quotient is rounded
// once.
inline ShortNumber read_short_number(const char* begin, const char* end) {
    const char* p = begin;
    const bool is_negative = p != end && *p == '-';
    p += is_negative;
    std::uint64_t digits = 0;
    const auto take_digits = [&] {
        const char* const first = p;
        for (; p != end; ++p) {
            const auto digit = static_cast<unsigned>(*p - '0');
            if (digit > 9) break;
            digits = digits * 10 + digit;
        }
        return p - first;
    };
    std::ptrdiff_t num_digits = take_digits(), num_behind = 0;
    if (p != end && *p == '.') {
        ++p;
        num_behind = take_digits();
        num_digits += num_behind;
    }
    if (num_digits == 0 || num_digits >= std::ssize(kPowersOfTen)) return {};
    const double size =
        static_cast<double>(digits) / kPowersOfTen[static_cast<std::size_t>(num_behind)];
    return {p, is_negative ? -size : size, num_behind > 0};
}

/// The numbers of a line, between blanks. Reads "nan", "inf", a leading '+', and Windows' "1.#QNAN"
/// (as NaN); the same bits in every locale.
class NumberReader {
 public:
    explicit NumberReader(std::string_view line) : rest_(line) {}

    bool next(double& value);  ///< false: see problem()
    bool skip();               ///< steps over a word without looking at it
    bool at_end();
    std::string_view problem() const { return problem_; }

 private:
    std::string_view rest_;
    std::string_view problem_;
};

}  // namespace pointbake
