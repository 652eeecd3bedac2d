#include "pointbake/options.h"

#include <array>
#include <charconv>
#include <cmath>

#include "core/message.h"
#include "pointbake/types.h"

namespace pointbake {

std::string_view to_string(DropReason reason) {
    static constexpr std::array<std::string_view, kNumDropReasons> words = {
        "kept",    "merged",     "non_finite", "off_surface", "outlier",   "floating",
        "cropped", "subsampled", "unreadable", "no_return",   "no_surfel", "withheld"};
    return words[static_cast<std::size_t>(reason)];
}

Length parse_length(std::string_view text) {
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    const std::string_view suffix = text.substr(static_cast<std::size_t>(end - text.data()));
    struct Unit {
        std::string_view suffix;
        Length length;
    };
    const std::array<Unit, 6> known = {{{"%", fraction(value / 100.0)},
                                        {"", units(value)},
                                        {"m", metres(value)},
                                        {"cm", metres(value * 0.01)},
                                        {"mm", metres(value * 0.001)},
                                        {"um", metres(value * 1e-6)}}};
    for (const Unit& unit : known) {
        if (error == std::errc{} && value >= 0.0 && value <= 1e300 && suffix == unit.suffix)
            return unit.length;
    }
    fail(ErrorCode::kInvalidOption,
         "'{}' is not a length: expected a share of the diagonal (0.1%), units (0.002) or a "
         "measure (2mm, 1.5cm, 3m)",
         text);
}

std::string to_string(const Length& length) {
    if (length.kind == Length::Kind::kFraction) return fmt::format("{}%", length.value * 100.0);
    return fmt::format("{}{}", length.value, length.kind == Length::Kind::kMetres ? "m" : "");
}

HexColor parse_hex_color(std::string_view text) {
    unsigned value = 0;
    const char* const end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, value, 16);
    if (text.size() != 6 || error != std::errc{} || stop != end)
        fail(ErrorCode::kInvalidOption, "'{}' is not a colour: expected six digits like ff00ff",
             text);
    return {static_cast<std::uint8_t>(value >> 16), static_cast<std::uint8_t>(value >> 8 & 255U),
            static_cast<std::uint8_t>(value & 255U)};
}

std::string to_string(HexColor color) {
    return fmt::format("{:02x}{:02x}{:02x}", color.r, color.g, color.b);
}

Box parse_box(std::string_view text) {
    std::array<double, 6> bounds{};
    const char* next = text.data();
    const char* const end = text.data() + text.size();
    for (std::size_t k = 0; k < bounds.size(); ++k) {
        const auto [stop, error] = std::from_chars(next, end, bounds[k]);
        const bool is_last = k + 1 == bounds.size();
        if (error != std::errc{} || !std::isfinite(bounds[k]) ||
            (is_last ? stop != end : stop == end || *stop != ','))
            fail(ErrorCode::kInvalidOption,
                 "'{}' is not a box: expected x0,y0,z0,x1,y1,z1 like -1,-1,0,1,1,2.5", text);
        next = is_last ? stop : stop + 1;
    }
    return {{bounds[0], bounds[1], bounds[2]}, {bounds[3], bounds[4], bounds[5]}};
}

std::string to_string(const Box& box) {
    return fmt::format("{},{},{},{},{},{}", box.low.x, box.low.y, box.low.z, box.high.x, box.high.y,
                       box.high.z);
}

}  // namespace pointbake
