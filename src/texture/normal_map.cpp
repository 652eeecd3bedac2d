#include "texture/normal_map.h"

#include <algorithm>

namespace pointbake {
TangentFrame tangent_frame(const TriangleFrame& frame, const PatchLayout& layout,
                           const Placement& placement) {
    // Rows run downwards: a layout that does not mirror turns the plane's y around.
    const bool turns = cross(layout.column_x, layout.column_y) < 0.0F;
    const Vec2d right =
        Vec2d{static_cast<double>(layout.column_y.y), -static_cast<double>(layout.column_x.y)} *
        (turns ? -1.0 : 1.0);
    const Vec3d t = normalized(frame.ex * right.x + frame.ey * right.y);
    const bool is_mirrored = turns == (placement.mirror_x != placement.mirror_y);
    return {vec_cast<float>(placement.mirror_x ? -t : t),
            static_cast<std::int8_t>(is_mirrored ? -1 : 1)};
}

void to_tangent_space(PatchTexels& patch, const Shell& shell, Index triangle,
                      const TangentFrame& tangent) {
    const Vec3d t = vec_cast<double>(tangent.tangent);
    const double sign = tangent.sign;
    for (int row = 0; row < patch.need.shape.height(); ++row) {
        const PatchShape::Span span = patch.need.shape.rows[static_cast<std::size_t>(row)];
        for (int i = span.left; i <= span.right; ++i) {
            const auto at = static_cast<std::size_t>(row) * static_cast<std::size_t>(patch.width) +
                            static_cast<std::size_t>(i);
            const Vec2f texel{static_cast<float>(i + patch.need.offset_x),
                              static_cast<float>(row + patch.need.offset_y)};
            const Vec3d n =
                shell.normal_at(triangle, vec_cast<double>(patch.layout.place_of(texel)));
            const Vec3d b = cross(n, t) * sign;
            const Vec3d wanted = vec_cast<double>(patch.values[at]);
            Vec3d local{dot(wanted, cross(b, n)), dot(wanted, cross(n, t)),
                        dot(wanted, cross(t, b))};
            local = normalized(local * sign);
            // Blue at or below one half does not occur in a valid map: such normals look away from
            // the surface.
            constexpr double kMinBlue = 0.02;
            if (local.z < kMinBlue) local.z = kMinBlue, local = normalized(local);
            patch.values[at] = vec_cast<float>(local);
            const Texel coded = encode(MapKind::kNormal, patch.values[at]);
            std::copy(coded.begin(), coded.end(),
                      patch.coded.begin() + static_cast<std::ptrdiff_t>(3 * at));
        }
    }
}

}  // namespace pointbake
