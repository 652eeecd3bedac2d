// The Gaussian exp(-q / 2), cut at q = kCut^2 and lowered so that it ends at 0 there: no jump at
// the rim. By table: the same bits on every machine.
#pragma once

#include <array>

namespace pointbake {

inline constexpr float kKernelCut = 3.0F;  // standard deviations
inline constexpr float kKernelCut2 = kKernelCut * kKernelCut;

class KernelTable {
 public:
    static constexpr int kSteps = 2048;

    /// exp(-x) by its series, halved until it converges fast.
    static constexpr double exp_minus(double x) {
        double y = x / 1024.0, term = 1.0, sum = 1.0;
        for (int k = 1; k < 12; ++k) {
            term *= -y / k;
            sum += term;
        }
        for (int k = 0; k < 10; ++k) sum *= sum;
        return sum;
    }

    constexpr KernelTable() {
        const double end = exp_minus(0.5 * static_cast<double>(kKernelCut2));
        for (int i = 0; i <= kSteps; ++i) {
            const double q = static_cast<double>(kKernelCut2) * i / kSteps;
            values_[static_cast<std::size_t>(i)] =
                static_cast<float>((exp_minus(0.5 * q) - end) / (1.0 - end));
        }
    }

    /// Weight at squared Mahalanobis distance q in [0, kKernelCut2).
    float operator()(float q) const {
        const float x = q * (static_cast<float>(kSteps) / kKernelCut2);
        const auto i = static_cast<std::size_t>(x);
        const float f = x - static_cast<float>(i);
        return values_[i] + (values_[i + 1] - values_[i]) * f;
    }

 private:
    std::array<float, kSteps + 2> values_{};
};

inline constexpr KernelTable kKernel{};

}  // namespace pointbake
