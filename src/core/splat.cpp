#include "core/splat.h"

#include <algorithm>

namespace pointbake {

bool holds_splats(const PointCloud& cloud) { return !cloud.axes.empty() && !cloud.weights.empty(); }

Splat splat_of(const PointCloud& cloud, std::size_t point) {
    constexpr float kThin = 0.1F;
    const Vec3f u = cloud.axes[point].u, v = cloud.axes[point].v;
    const Vec3f across = cross(u, v);
    const bool is_flat = !cloud.normals.empty() && !(cloud.normals[point] == Vec3f{});
    Splat out;
    out.center = cloud.positions[point];
    if (!(length(across) > 0.0F)) return out;
    out.axes[0] = u / length(u);
    out.axes[2] = across / length(across);
    out.axes[1] = cross(out.axes[2], out.axes[0]);
    const float second = length(v);
    out.sigmas = {length(u), second, std::min(length(u), second) * (is_flat ? kThin : 1.0F)};
    out.opacity = std::clamp(cloud.weights[point], 0.0F, kMostOpaque);
    return out;
}

}  // namespace pointbake
