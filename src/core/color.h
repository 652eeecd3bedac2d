// sRGB to linear light and back. No libm beyond sqrt: the same bits on every machine.
#pragma once

#include <array>
#include <cstdint>

#include "pointbake/types.h"

namespace pointbake {

/// Linear light in [0, 1] of an sRGB-coded 16-bit value (65535 = 1).
float srgb_to_linear(std::uint16_t coded);
/// Linear light of an sRGB value in [0, 1].
double srgb_to_linear_exact(double coded);
/// sRGB value in [0, 1] of linear light in [0, 1]; clamps.
double linear_to_srgb_exact(double linear);
/// Nearest 8-bit sRGB code of linear light; clamps. Exact: the code whose linear interval holds the
/// value.
std::uint8_t linear_to_srgb8(float linear);
/// sRGB value on the 8-bit scale (0..255, not rounded), by table: within 0.01 of exact.
float linear_to_srgb255(float linear);

inline Vec3f to_linear(Rgb16 c) {
    return {srgb_to_linear(c.r), srgb_to_linear(c.g), srgb_to_linear(c.b)};
}
inline Rgb16 rgb16_from_8bit(std::uint8_t r, std::uint8_t g, std::uint8_t b) {
    return {static_cast<std::uint16_t>(r * 257), static_cast<std::uint16_t>(g * 257),
            static_cast<std::uint16_t>(b * 257)};
}
/// The 8-bit code of a 16-bit one, rounded.
inline std::uint8_t to_8bit(std::uint16_t v) {
    return static_cast<std::uint8_t>((v + 128U) / 257U);
}
/// The nearest colour of 8 bits.
inline Rgb16 rounded_to_8bit(Rgb16 c) {
    return rgb16_from_8bit(to_8bit(c.r), to_8bit(c.g), to_8bit(c.b));
}

}  // namespace pointbake
