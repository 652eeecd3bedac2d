#include "core/splat.h"

#include <algorithm>

namespace pointbake {

Splat splat_of(const PointCloud& cloud, std::size_t point) {
    constexpr float kThin = 0.1F;
    const Vec3f u = cloud.axes[point].u, v = cloud.axes[point].v;
    const float first = length(u), second = length(v);
    const bool is_flat = !cloud.normals.empty() && !(cloud.normals[point] == Vec3f{});
    Splat out;
    out.center = cloud.positions[point];
    if (!(first > 0.0F && second > 0.0F)) return out;
    const Vec3f across = cross(u / first, v / second);
    constexpr float kParallel = 1e-6F;
    if (!(length(across) > kParallel)) return out;
    out.axes[0] = u / first;
    out.axes[2] = across / length(across);
    out.axes[1] = cross(out.axes[2], out.axes[0]);
    out.sigmas = {first, second, std::min(first, second) * (is_flat ? kThin : 1.0F)};
    out.opacity = std::clamp(cloud.weights[point], 0.0F, kMostOpaque);
    return out;
}

}  // namespace pointbake
