#include "option_value.h"

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

namespace pointbake::cli {

std::string json_string(std::string_view text) {
    // File names need not be UTF-8: what is not is replaced, since JSON cannot hold it.
    return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

bool OptionValue<bool>::parse(std::string_view text) {
    if (text == "true") return true;
    if (text == "false") return false;
    fail(ErrorCode::kInvalidOption, "'{}' is not known: expected true or false", text);
}

double OptionValue<double>::parse(std::string_view text) {
    double value = 0.0;
    const char* const end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, value);
    if (error != std::errc{} || stop != end || !std::isfinite(value))
        fail(ErrorCode::kInvalidOption, "'{}' is not a number: expected something like 2.5", text);
    return value;
}

Vec3d OptionValue<Vec3d>::parse(std::string_view text) {
    Vec3d value;
    const bool is_minus = text.starts_with('-');
    if (const std::string_view axis = text.substr(is_minus ? 1 : 0);
        axis.size() == 1 && 'x' <= axis[0] && axis[0] <= 'z') {
        value[static_cast<std::size_t>(axis[0] - 'x')] = is_minus ? -1.0 : 1.0;
        return value;
    }
    const char* next = text.data();
    const char* const end = text.data() + text.size();
    for (std::size_t k = 0; k < 3; ++k) {
        const auto [stop, error] = std::from_chars(next, end, value[k]);
        const bool is_last = k == 2;
        if (error != std::errc{} || !std::isfinite(value[k]) ||
            (is_last ? stop != end : stop == end || *stop != ','))
            fail(ErrorCode::kInvalidOption,
                 "'{}' is not a direction: expected x, -x, y, -y, z, -z or three numbers like "
                 "1,0.5,-2",
                 text);
        next = is_last ? stop : stop + 1;
    }
    return value;
}

std::optional<std::uint64_t> parse_count(std::string_view text) {
    const char* const end = text.data() + text.size();
    std::uint64_t whole = 0;
    const auto [stop, error] = std::from_chars(text.data(), end, whole);
    if (error == std::errc::result_out_of_range) return std::nullopt;
    if (error == std::errc{} && stop == end) return whole;
    constexpr double kMost = 1e15;  // doubles hold each whole number up to it
    const double unit = text.ends_with('k') || text.ends_with('K') ? 1e3
                        : text.ends_with('M')                      ? 1e6
                                                                   : 0.0;
    double value = 0.0;
    const auto [last, fault] = std::from_chars(text.data(), end, value, std::chars_format::fixed);
    const double count = std::round(value * unit);
    if (fault != std::errc{} || last + 1 != end || unit == 0.0 || !(count >= 0.0) ||
        std::abs(count - value * unit) > 1e-9 * count)
        fail(ErrorCode::kInvalidOption,
             "'{}' is not a count: expected a whole number that is not negative, or thousands and "
             "millions as 250k and 1.5M",
             text);
    if (count > kMost) return std::nullopt;
    return static_cast<std::uint64_t>(count);
}

ByteSize OptionValue<ByteSize>::parse(std::string_view text) {
    struct Unit {
        std::string_view suffix;
        std::uint64_t bytes;
    };
    static constexpr std::array<Unit, 5> units = {
        {{"", 1}, {"K", 1ULL << 10}, {"M", 1ULL << 20}, {"G", 1ULL << 30}, {"T", 1ULL << 40}}};
    // No machine has more; keeps the product within 64 bits.
    constexpr double kMostBytes = 1e18;
    double value = 0.0;
    const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    const std::string_view suffix(stop, text.data() + text.size());
    for (const Unit& unit : units) {
        const double bytes = value * static_cast<double>(unit.bytes);
        if (error == std::errc{} && suffix == unit.suffix && bytes > 0.0 && bytes < kMostBytes)
            return {static_cast<std::uint64_t>(bytes)};
    }
    fail(ErrorCode::kInvalidOption, "'{}' is not an amount of memory: expected 500M, 12G or bytes",
         text);
}

}  // namespace pointbake::cli
