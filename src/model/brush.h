// Laying colours over each other with soft edges.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "pointbake/types.h"

namespace pointbake {

/// Width of every painted edge, as a share of the model's longest side: about the spacing of a
/// million points, so that a dense cloud holds the whole ramp.
inline constexpr double kEdgeRamp = 0.0015;

/// How much of a shape covers a place at this signed distance from its outline (negative inside).
inline double coverage(double distance) { return std::clamp(0.5 - distance / kEdgeRamp, 0.0, 1.0); }
/// 0 up to `low`, 1 from `high` on, straight in between.
inline double ramp(double value, double low, double high) {
    return std::clamp((value - low) / (high - low), 0.0, 1.0);
}
/// Signed distance to the ends of an interval, negative within.
inline double outside(double value, double low, double high) {
    return std::max(low - value, value - high);
}

/// A colour on the 8-bit sRGB scale.
struct Brush {
    Vec3d color;

    void lay(Vec3d over, double share) {
        if (share >= 1.0) {
            color = over;
        } else if (share > 0.0) {
            color = color * (1.0 - share) + over * share;
        }
    }
    /// A filled shape.
    void fill(Vec3d over, double distance) { lay(over, coverage(distance)); }
    Rgb16 rgb16() const {
        const auto code = [](double v) { return static_cast<std::uint16_t>(v * 257.0 + 0.5); };
        return {code(color.x), code(color.y), code(color.z)};
    }
};

namespace palette {
inline constexpr Vec3d kIvory{246, 238, 219}, kNavy{24, 34, 66}, kRed{199, 44, 38};
inline constexpr Vec3d kSky{104, 174, 222}, kPale{222, 239, 247}, kSea{28, 92, 122};
inline constexpr Vec3d kOchre{228, 178, 76}, kGold{240, 160, 40}, kTerracotta{193, 88, 60};
inline constexpr Vec3d kGrass{138, 178, 96}, kMeadow{178, 205, 130}, kLeaf{78, 148, 62};
inline constexpr Vec3d kDeepLeaf{44, 104, 52}, kWhite{252, 250, 245}, kPink{238, 128, 152};
inline constexpr Vec3d kYellow{247, 196, 40}, kBark{176, 148, 112}, kOrange{226, 110, 40};
}  // namespace palette

}  // namespace pointbake
