// What a map's values are, how they become bytes and what a difference of 1 means. Colours are
// sRGB-coded in [0, 1]: between points they are interpolated so, which comes nearer to the truth at
// edges than linear light (docs/decisions.md); averages are taken in linear light.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "core/color.h"
#include "pointbake/types.h"

namespace pointbake {

enum class MapKind { kColor, kNormal };

inline Vec3f color_value(Rgb16 c) {
    return Vec3f{static_cast<float>(c.r), static_cast<float>(c.g), static_cast<float>(c.b)} /
           65535.0F;
}
/// Linear light of a colour value; clamps.
inline Vec3f value_to_linear(Vec3f v) {
    const auto code = [](float x) {
        return static_cast<std::uint16_t>(std::clamp(x, 0.0F, 1.0F) * 65535.0F + 0.5F);
    };
    return to_linear({code(v.x), code(v.y), code(v.z)});
}
inline Vec3f linear_to_value(Vec3f v) {
    return Vec3f{linear_to_srgb255(v.x), linear_to_srgb255(v.y), linear_to_srgb255(v.z)} / 255.0F;
}

/// What is splatted, per item of the footprints.
struct MapValues {
    MapKind kind = MapKind::kColor;
    std::span<const Vec3f> values;    ///< sharpened
    std::span<const Vec3f> linear;    ///< the same in linear light; empty for normals
    std::span<const Vec3f> splatted;  ///< their splatted function at the items
};

/// Value on the 8-bit scale (0..255, not rounded): errors are measured here. Colours beyond black
/// and white, which sharpening makes, are seen as those.
inline Vec3f to_steps(MapKind kind, Vec3f v) {
    if (kind == MapKind::kColor) {
        const auto step = [](float x) { return std::clamp(255.0F * x, 0.0F, 255.0F); };
        return {step(v.x), step(v.y), step(v.z)};
    }
    return {127.5F * (v.x + 1.0F), 127.5F * (v.y + 1.0F), 127.5F * (v.z + 1.0F)};
}

using Texel = std::array<std::uint8_t, 3>;

inline Texel encode(MapKind kind, Vec3f v) {
    const Vec3f steps = to_steps(kind, v);
    const auto code = [](float x) {
        return static_cast<std::uint8_t>(std::clamp(x + 0.5F, 0.0F, 255.0F));
    };
    return {code(steps.x), code(steps.y), code(steps.z)};
}

/// What texture hardware filters: linear light, or vectors.
inline Vec3f decode(MapKind kind, Texel t) {
    if (kind == MapKind::kColor) return to_linear(rgb16_from_8bit(t[0], t[1], t[2]));
    const auto value = [](std::uint8_t c) { return static_cast<float>(c) / 127.5F - 1.0F; };
    return {value(t[0]), value(t[1]), value(t[2])};
}

}  // namespace pointbake
