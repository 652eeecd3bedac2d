// IEC 61966-2-1. x^2.4 = x^2 (x^2)^(1/5) and x^(1/2.4) = (x^5)^(1/12): roots by Newton's iteration,
// so no pow().
#include "core/color.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

namespace pointbake {
namespace {

constexpr double kLinearEnd = 0.0031308;  // end of the linear part of the curve, in linear light
constexpr double kCodedEnd = 0.04045;     // the same point, coded

double fifth_root(double x) {
    if (x <= 0.0) return 0.0;
    double r = x < 1.0 ? 1.0 : x;  // from above: the iteration falls monotonically
    for (int i = 0; i < 60; ++i) {
        const double r4 = r * r * r * r;
        const double next = (4.0 * r + x / r4) / 5.0;
        if (!(next < r)) break;
        r = next;
    }
    return r;
}

double cube_root(double x) {
    if (x <= 0.0) return 0.0;
    double r = x < 1.0 ? 1.0 : x;
    for (int i = 0; i < 60; ++i) {
        const double next = (2.0 * r + x / (r * r)) / 3.0;
        if (!(next < r)) break;
        r = next;
    }
    return r;
}

struct Tables {
    std::vector<float> linear_of_16bit = std::vector<float>(65536);
    std::array<float, 257> edges{};  // linear light where code i begins; [256] = above all
    std::array<std::uint8_t, 4097> first_code{};  // lower bound of the code, by sqrt(linear) * 4096
    std::array<float, 4098> srgb255{};            // by sqrt(linear) * 4096

    Tables() {
        for (int i = 0; i < 65536; ++i)
            linear_of_16bit[static_cast<std::size_t>(i)] =
                static_cast<float>(srgb_to_linear_exact(i / 65535.0));
        for (int i = 0; i <= 256; ++i) {
            edges[static_cast<std::size_t>(i)] =
                i == 0 ? -1.0F
                       : (i == 256 ? 2.0F
                                   : static_cast<float>(srgb_to_linear_exact((i - 0.5) / 255.0)));
        }
        int code = 0;
        for (int i = 0; i <= 4097; ++i) {
            const double linear = std::min(1.0, (i / 4096.0) * (i / 4096.0));
            srgb255[static_cast<std::size_t>(i)] =
                static_cast<float>(255.0 * linear_to_srgb_exact(linear));
            if (i > 4096) break;
            while (code < 255 &&
                   static_cast<double>(edges[static_cast<std::size_t>(code) + 1]) <= linear)
                ++code;
            first_code[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(code);
        }
    }
};

const Tables& tables() {
    static const Tables t;
    return t;
}

}  // namespace

double srgb_to_linear_exact(double coded) {
    if (coded <= kCodedEnd) return coded / 12.92;
    const double x = (coded + 0.055) / 1.055;
    return x * x * fifth_root(x * x);
}

double linear_to_srgb_exact(double linear) {
    if (!(linear > 0.0)) return 0.0;
    if (linear >= 1.0) return 1.0;
    if (linear <= kLinearEnd) return 12.92 * linear;
    // x^(5/12) = cbrt(x^(5/4)) = cbrt(x * sqrt(sqrt(x)))
    return 1.055 * cube_root(linear * std::sqrt(std::sqrt(linear))) - 0.055;
}

float srgb_to_linear(std::uint16_t coded) { return tables().linear_of_16bit[coded]; }

std::uint8_t linear_to_srgb8(float linear) {
    if (!(linear > 0.0F)) return 0;
    if (linear >= 1.0F) return 255;
    const Tables& t = tables();
    std::size_t code = t.first_code[static_cast<std::size_t>(std::sqrt(linear) * 4096.0F)];
    while (code > 0 && linear < t.edges[code]) --code;
    while (linear >= t.edges[code + 1]) ++code;
    return static_cast<std::uint8_t>(code);
}

float linear_to_srgb255(float linear) {
    if (!(linear > 0.0F)) return 0.0F;
    if (linear >= 1.0F) return 255.0F;
    const Tables& t = tables();
    const float x = std::sqrt(linear) * 4096.0F;
    const auto i = static_cast<std::size_t>(x);
    const float f = x - static_cast<float>(i);
    return t.srgb255[i] * (1.0F - f) + t.srgb255[i + 1] * f;
}

}  // namespace pointbake
