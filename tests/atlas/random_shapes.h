// Sets of triangles as they come out of the texture stage: vertices on texels, base along x.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/hash.h"
#include "pointbake/patch.h"

namespace pointbake {

inline PatchShape triangle_shape(double base, double height, double foot) {
    const double b = std::max(1.0, std::round(base)), h = std::max(1.0, std::round(height));
    return need_set({Vec2d{0, h}, Vec2d{b, h}, Vec2d{foot, 0}}).shape;
}

/// About normally distributed, variance 1.
inline double random_normal(std::uint64_t seed, std::uint64_t i) {
    double sum = -6.0;
    for (std::uint64_t k = 0; k < 12; ++k) sum += random_unit(seed, 12 * i + k);
    return sum;
}

/// Bases are log-normal: exp(spread) is one standard deviation.
inline std::vector<PatchShape> log_normal_shapes(int count, double median_base, double spread,
                                                 std::uint64_t seed = 1) {
    std::vector<PatchShape> out;
    for (int n = 0; n < count; ++n) {
        const auto i = static_cast<std::uint64_t>(n);
        const double base = median_base * std::exp(spread * random_normal(seed, i));
        const double aspect = 0.45 + 0.4 * random_unit(seed + 100, i);
        out.push_back(
            triangle_shape(base, base * aspect, base * (0.15 + 0.7 * random_unit(seed + 200, i))));
    }
    return out;
}

}  // namespace pointbake
