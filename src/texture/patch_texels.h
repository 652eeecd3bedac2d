// One patch: where a triangle's corners lie among its texels, and what the texels hold.
#pragma once

#include <cmath>
#include <vector>

#include "pointbake/patch.h"
#include "texture/coding.h"
#include "texture/local_field.h"

namespace pointbake {

/// Layout of a triangle at a size. y grows downwards. In a patch of its own all corners are on
/// texel centres and the apex is in row 0; base = 0 is the one-texel patch.
struct PatchLayout {
    int base = 0, height = 0, apex = 0;  ///< whole texels, of a patch of its own
    std::array<Vec2d, 3> corners{};      ///< per corner of the triangle
    Vec2f origin{};                      ///< texel = origin + x * column_x + y * column_y
    Vec2f column_x{}, column_y{};

    Vec2f texel_of(Vec2f x) const { return origin + column_x * x.x + column_y * x.y; }
    /// Edge of a texel in cloud units.
    double pitch() const {
        return 1.0 / std::sqrt(std::fabs(static_cast<double>(cross(column_x, column_y))));
    }
    /// Inverse of texel_of, where the columns span an area.
    Vec2f place_of(Vec2f texel) const {
        const Vec2f d = texel - origin;
        return Vec2f{cross(d, column_y), cross(column_x, d)} / cross(column_x, column_y);
    }
};
PatchLayout patch_layout(const TriangleFrame& frame, double texels_per_unit);
/// A triangle whose corners lie anywhere among the texels; they must span an area.
PatchLayout patch_layout(const TriangleFrame& frame, const std::array<Vec2d, 3>& texels);
inline constexpr double kOneTexel = 0.0;  ///< density of the one-texel patch

/// Texels of a need set, before and after quantisation.
struct PatchTexels {
    PatchLayout layout;
    NeedSet need;
    int width = 0;                           ///< of the need set's box
    std::vector<Vec3f> values;               ///< width * height, as coding.h has them
    std::vector<std::uint8_t> coded;         ///< 3 per texel
    std::vector<std::uint8_t> is_uncovered;  ///< no splat reached it; filled from those around

    std::size_t at(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
               static_cast<std::size_t>(x);
    }
    Vec3f value(int x, int y) const { return values[at(x, y)]; }
    Texel texel(int x, int y) const {
        const std::size_t i = 3 * at(x, y);
        return {coded[i], coded[i + 1], coded[i + 2]};
    }
};

/// How texels stand to the points' spacing.
struct TexelFilter {
    float variance = 0.0F;      ///< of the screen filter, texels^2
    float linear_share = 0.0F;  ///< 0: texels interpolate codes; 1: they average linear light
};

/// Splats the gathered field into some texels of a patch of the given layout (EWA, [Zwicker01]).
/// Texels that no splat reaches take the widened splats' value.
PatchTexels splat_patch(const LocalField& field, const MapValues& map, const PatchLayout& layout,
                        NeedSet need, TexelFilter filter);

/// What a renderer reads at texel coordinates u (integers are centres): bilinear over the decoded
/// bytes, in linear light for colours. As a value.
Vec3f sample_bilinear(const PatchTexels& patch, MapKind kind, Vec2f u);

}  // namespace pointbake
