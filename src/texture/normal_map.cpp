#include "texture/normal_map.h"

#include <algorithm>

namespace pointbake {
namespace {

// Interpolated vertex normal at a place in the triangle's plane, clamped into the triangle.
Vec3d normal_at(const Shell& shell, const Mesh& mesh, Index triangle, Vec2f place) {
    const std::array<Vec2d, 3>& c = shell.frame(triangle).corners;
    const Vec2d x{static_cast<double>(place.x), static_cast<double>(place.y)};
    const double area = cross(c[1] - c[0], c[2] - c[0]);
    if (!(area > 0.0)) return shell.frame(triangle).ez;
    std::array<double, 3> b = {cross(c[1] - x, c[2] - x) / area, cross(c[2] - x, c[0] - x) / area,
                               0.0};
    b[2] = 1.0 - b[0] - b[1];
    double sum = 0.0;
    for (double& w : b) w = std::max(w, 0.0), sum += w;
    Vec3d n{};
    for (std::size_t k = 0; k < 3; ++k) {
        n += vec_cast<double>(shell.normals()[mesh.triangles[triangle][k]]) * (b[k] / sum);
    }
    return n;
}

}  // namespace

TangentFrame to_tangent_space(PatchTexels& patch, const Shell& shell, const Mesh& mesh,
                              Index triangle, const Placement& placement) {
    const double side = placement.mirror_x ? -1.0 : 1.0;
    const double sign = placement.mirror_x == placement.mirror_y ? 1.0 : -1.0;
    const Vec3d t = shell.frame(triangle).ex * side;
    for (int row = 0; row < patch.need.shape.height(); ++row) {
        const PatchShape::Span span = patch.need.shape.rows[static_cast<std::size_t>(row)];
        for (int i = span.left; i <= span.right; ++i) {
            const auto at =
                static_cast<std::size_t>(row) * static_cast<std::size_t>(patch.width()) +
                static_cast<std::size_t>(i);
            const Vec2f texel{static_cast<float>(i + patch.need.offset_x),
                              static_cast<float>(row + patch.need.offset_y)};
            const Vec3d n = normal_at(shell, mesh, triangle, patch.layout.place_of(texel));
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
    return {vec_cast<float>(t), static_cast<std::int8_t>(sign)};
}

}  // namespace pointbake
