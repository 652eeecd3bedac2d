// How a map's values become bytes and what a difference of 1 means: colours (linear light -> sRGB)
// or unit vectors.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "core/color.h"
#include "pointbake/types.h"

namespace pointbake {

enum class MapKind { kColor, kNormal };

/// Value on the 8-bit scale (0..255, not rounded): errors are measured here.
inline Vec3f to_steps(MapKind kind, Vec3f v) {
    if (kind == MapKind::kColor) {
        return {linear_to_srgb255(v.x), linear_to_srgb255(v.y), linear_to_srgb255(v.z)};
    }
    return {127.5F * (v.x + 1.0F), 127.5F * (v.y + 1.0F), 127.5F * (v.z + 1.0F)};
}

using Texel = std::array<std::uint8_t, 3>;

inline Texel encode(MapKind kind, Vec3f v) {
    if (kind == MapKind::kColor) {
        return {linear_to_srgb8(v.x), linear_to_srgb8(v.y), linear_to_srgb8(v.z)};
    }
    const auto code = [](float x) {
        return static_cast<std::uint8_t>(std::clamp(127.5F * (x + 1.0F) + 0.5F, 0.0F, 255.0F));
    };
    return {code(v.x), code(v.y), code(v.z)};
}

inline Vec3f decode(MapKind kind, Texel t) {
    if (kind == MapKind::kColor) return to_linear(rgb16_from_8bit(t[0], t[1], t[2]));
    const auto value = [](std::uint8_t c) { return static_cast<float>(c) / 127.5F - 1.0F; };
    return {value(t[0]), value(t[1]), value(t[2])};
}

}  // namespace pointbake
