// Lines and numbers of text files.
#pragma once

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

/// A number of at most 15 digits without an exponent: the same bits as std::from_chars gives,
/// sooner.
ShortNumber read_short_number(const char* begin, const char* end);

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
