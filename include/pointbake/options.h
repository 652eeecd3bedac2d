// Building blocks of the options structs. A struct declares each option once, in describe(): its
// name, the member, its help. The member's initialiser is the default. The command line,
// --dump-options and the docs are generated from it.
//
//     struct SimplifyOptions {
//         Index triangles = 0;
//         template <class Field> static void describe(Field&& field) {
//             field("triangles", &SimplifyOptions::triangles, "stop at this many triangles; 0 = no
//             target");
//         }
//     };
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "pointbake/vec.h"

namespace pointbake {

/// A length: a fraction of the bounding-box diagonal ("0.1%"), cloud units ("0.002") or metres
/// ("2mm", "1.5cm", "3m"). Stages take a cloud unit for a metre; in_cloud_units() knows better.
struct Length {
    enum class Kind { kFraction, kUnits, kMetres };
    Kind kind = Kind::kUnits;
    double value = 0.0;

    double in_units(double diagonal) const {
        return kind == Kind::kFraction ? value * diagonal : value;
    }
    friend bool operator==(const Length&, const Length&) = default;
};
constexpr Length fraction(double f) { return {Length::Kind::kFraction, f}; }
constexpr Length metres(double m) { return {Length::Kind::kMetres, m}; }
constexpr Length units(double u) { return {Length::Kind::kUnits, u}; }

/// Reads "0.1%", "0.002", "2mm"; throws Error{kInvalidOption} naming what would be accepted.
Length parse_length(std::string_view text);
std::string to_string(const Length& length);

/// An 8-bit colour, like "ff00ff".
struct HexColor {
    std::uint8_t r = 0, g = 0, b = 0;
};
/// Throws Error{kInvalidOption} naming what would be accepted.
HexColor parse_hex_color(std::string_view text);
std::string to_string(HexColor color);

/// Reads "x0,y0,z0,x1,y1,z1". Throws Error{kInvalidOption} naming what would be accepted.
Box parse_box(std::string_view text);
std::string to_string(const Box& box);

/// The words of an enum, in the order of its values (0, 1, ...). Specialise as
///     template <> struct EnumWords<Shading> { static constexpr std::string_view words[] =
///     {"unlit", "lit"}; };
template <class E>
struct EnumWords;

template <class E>
constexpr std::string_view to_word(E value) {
    return EnumWords<E>::words[static_cast<std::size_t>(value)];
}
template <class E>
constexpr std::optional<E> from_word(std::string_view word) {
    std::size_t i = 0;
    for (std::string_view w : EnumWords<E>::words) {
        if (w == word) return static_cast<E>(i);
        ++i;
    }
    return std::nullopt;
}

}  // namespace pointbake
