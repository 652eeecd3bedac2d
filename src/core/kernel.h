// The Gaussian exp(-q / 2), cut at q = cut2 and lowered so that it ends at 0 there: no jump at the
// rim. By a polynomial: the same bits on every machine, and loops over it vectorise.
#pragma once

namespace pointbake {

/// Standard deviation of a splat over its spacing.
inline constexpr float kSplatSigma = 0.6F;

/// exp(-q / 2) = exp(-q / 16)^8 for q in [0, 9]: relative error below 4e-4.
constexpr float gaussian(float q) {
    const float t = q * (1.0F / 16.0F);
    const float e =
        1.0F -
        t * (1.0F - t * (0.5F - t * (1.0F / 6.0F - t * (1.0F / 24.0F - t * (1.0F / 120.0F)))));
    const float e2 = e * e, e4 = e2 * e2;
    return e4 * e4;
}

/// How a surfel is drawn.
struct Kernel {
    float sigma = kSplatSigma;  ///< standard deviation over sqrt(area of the point)
    float cut = 2.5F;           ///< in standard deviations
    float cut2 = 6.25F;
    float rim = gaussian(6.25F);  ///< value that is taken off so that the kernel ends at 0
    float low_pass = 0.25F;  ///< variance of the screen filter where texels are coarse, texels^2
    bool fades_low_pass = true;  ///< the filter vanishes where texels are finer than the points

    /// Weight at squared Mahalanobis distance q in [0, cut2].
    float operator()(float q) const {
        const float w = gaussian(q) - rim;
        return w > 0.0F ? w : 0.0F;
    }
};

/// PointShop3D's, which [Wicke05] was built on: exp(-|u / r|^2) cut at |u| = r = the spacing, that
/// is sigma = r / sqrt(2) and a cut at sqrt(2) sigma; screen filter of variance 0.5.
constexpr Kernel point_shop_kernel() { return {0.70710678F, 1.41421356F, 2.0F, 0.0F, 0.5F, false}; }

}  // namespace pointbake
