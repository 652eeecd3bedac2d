#include "core/color.h"

#include <gtest/gtest.h>

#include <cmath>

namespace pointbake {
namespace {

double reference_to_linear(double coded) {
    return coded <= 0.04045 ? coded / 12.92 : std::pow((coded + 0.055) / 1.055, 2.4);
}
double reference_to_srgb(double linear) {
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
}
std::uint16_t code16(int code) { return static_cast<std::uint16_t>(code * 257); }

TEST(Color, RoundTripsEveryCode) {
    for (int code = 0; code < 256; ++code) {
        EXPECT_EQ(linear_to_srgb8(srgb_to_linear(code16(code))), code);
        EXPECT_EQ(to_8bit(code16(code)), code);
        EXPECT_NEAR(linear_to_srgb255(srgb_to_linear(code16(code))), code, 0.01);
    }
}

TEST(Color, LinearLightRisesWithTheCode) {
    for (int code = 1; code < 65536; ++code)
        ASSERT_GT(srgb_to_linear(static_cast<std::uint16_t>(code)),
                  srgb_to_linear(static_cast<std::uint16_t>(code - 1)))
            << code;
}

TEST(Color, AgreesWithThePowerFunction) {
    for (int i = 0; i <= 4000; ++i) {
        const double x = i / 4000.0;
        EXPECT_NEAR(srgb_to_linear_exact(x), reference_to_linear(x), 1e-12);
        EXPECT_NEAR(linear_to_srgb_exact(x), reference_to_srgb(x), 1e-12);
    }
    // 0 and the steepest part of the root
    for (double x = 1e-9; x < 1e-2; x *= 1.3)
        EXPECT_NEAR(linear_to_srgb_exact(x), reference_to_srgb(x), 1e-12);
}

TEST(Color, RoundsToTheNearestCode) {
    for (int i = 0; i <= 100'000; ++i) {
        const auto linear = static_cast<float>(i / 100'000.0);
        const double exact = 255.0 * reference_to_srgb(linear);
        // float edges may fall either way within their rounding
        ASSERT_LE(std::fabs(linear_to_srgb8(linear) - exact), 0.5001) << linear;
        ASSERT_NEAR(linear_to_srgb255(linear), exact, 0.01) << linear;
    }
}

TEST(Color, CodesNeverFallAsLightRises) {
    int last = 0;
    for (int i = 0; i <= 200'000; ++i) {
        const int code = linear_to_srgb8(static_cast<float>(i) / 200'000.0F);
        ASSERT_GE(code, last);
        last = code;
    }
    EXPECT_EQ(last, 255);
}

TEST(Color, ClampsWhatIsNoLight) {
    EXPECT_EQ(linear_to_srgb8(-1.0F), 0);
    EXPECT_EQ(linear_to_srgb8(7.0F), 255);
    EXPECT_EQ(linear_to_srgb8(NAN), 0);
    EXPECT_EQ(linear_to_srgb255(-1.0F), 0.0F);
    EXPECT_EQ(linear_to_srgb255(7.0F), 255.0F);
    EXPECT_EQ(linear_to_srgb_exact(-0.1), 0.0);
    EXPECT_EQ(linear_to_srgb_exact(1.1), 1.0);
}

}  // namespace
}  // namespace pointbake
