// One patch: where a triangle's corners lie among its texels, and what the texels hold.
#pragma once

#include <vector>

#include "pointbake/patch.h"
#include "texture/coding.h"
#include "texture/local_field.h"

namespace pointbake {

/// Layout of a triangle at a size. All corners are on texel centres; y grows downwards, the apex is
/// in row 0. base = 0 is the one-texel patch.
struct PatchLayout {
    int base = 0, height = 0, apex = 0;  ///< whole texels
    std::array<Vec2d, 3> corners{};      ///< per corner of the triangle
    Vec2f origin{};                      ///< texel = origin + x * column_x + y * column_y
    Vec2f column_x{}, column_y{};

    Vec2f texel_of(Vec2f x) const {
        return {origin.x + column_x.x * x.x + column_y.x * x.y, origin.y + column_y.y * x.y};
    }
    /// Inverse of texel_of for a patch with base > 0.
    Vec2f place_of(Vec2f texel) const {
        const float y = (texel.y - origin.y) / column_y.y;
        return {(texel.x - origin.x - column_y.x * y) / column_x.x, y};
    }
};
PatchLayout patch_layout(const TriangleFrame& frame, double texels_per_unit);
inline constexpr double kOneTexel = 0.0;  ///< density of the one-texel patch

/// Texels of a need set, before and after quantisation.
struct PatchTexels {
    PatchLayout layout;
    NeedSet need;
    std::vector<Vec3f> values;        ///< width * height, linear light
    std::vector<std::uint8_t> coded;  ///< 3 per texel
    std::uint64_t num_uncovered = 0;

    int width() const { return need.shape.width(); }
    Texel texel(int x, int y) const {
        const auto i = 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width()) +
                            static_cast<std::size_t>(x));
        return {coded[i], coded[i + 1], coded[i + 2]};
    }
};

/// Splats the gathered field into a patch of the given layout (EWA, [Zwicker01]); low_pass is the
/// variance of the screen filter in texels^2. Texels that no splat reaches take the widened splats'
/// value and are counted.
PatchTexels splat_patch(const LocalField& field, std::span<const Vec3f> values, MapKind kind,
                        const PatchLayout& layout, float low_pass);

/// What a renderer reads at texel coordinates u (integers are centres): bilinear over the decoded
/// bytes.
Vec3f sample_bilinear(const PatchTexels& patch, MapKind kind, Vec2f u);

}  // namespace pointbake
