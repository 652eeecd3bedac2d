// The Gaussian exp(-q / 2), cut at q = kCut^2 and lowered so that it ends at 0 there: no jump at
// the rim. By a polynomial: the same bits on every machine, and loops over it vectorise.
#pragma once

namespace pointbake {

inline constexpr float kKernelCut = 3.0F;  // standard deviations
inline constexpr float kKernelCut2 = kKernelCut * kKernelCut;

/// exp(-q / 2) = exp(-q / 16)^8 for q in [0, kKernelCut2]: relative error below 4e-4.
constexpr float gaussian(float q) {
    const float t = q * (1.0F / 16.0F);
    const float e =
        1.0F -
        t * (1.0F - t * (0.5F - t * (1.0F / 6.0F - t * (1.0F / 24.0F - t * (1.0F / 120.0F)))));
    const float e2 = e * e, e4 = e2 * e2;
    return e4 * e4;
}

/// Weight at squared Mahalanobis distance q in [0, kKernelCut2]: 1 at 0, 0 at the rim.
constexpr float kernel(float q) {
    constexpr float end = gaussian(kKernelCut2);
    constexpr float scale = 1.0F / (1.0F - end);
    const float w = (gaussian(q) - end) * scale;
    return w > 0.0F ? w : 0.0F;
}

}  // namespace pointbake
