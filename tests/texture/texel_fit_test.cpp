#include "texture/texel_fit.h"

#include <gtest/gtest.h>

#include <cmath>

namespace pointbake {
namespace {

constexpr int kSide = 16;

TexelFit::Values grey() {
    return {std::vector<Vec3f>(std::size_t{kSide} * kSide, Vec3f{0.5F, 0.5F, 0.5F})};
}

float read(const TexelFit::Values& v, double x, double y) {
    const int i = static_cast<int>(x), j = static_cast<int>(y);
    const auto fx = static_cast<float>(x - i), fy = static_cast<float>(y - j);
    const auto at = [&](int a, int b) { return v[0][static_cast<std::size_t>(b * kSide + a)].x; };
    return (at(i, j) * (1 - fx) + at(i + 1, j) * fx) * (1 - fy) +
           (at(i, j + 1) * (1 - fx) + at(i + 1, j + 1) * fx) * fy;
}

TEST(TexelFit, FindsTexelsThatReadAsTheSamplesSay) {
    // A smooth function, known four times per texel; bilinear texels can follow it closely.
    const std::vector<PageSize> pages{{kSide, kSide}};
    const TexelFit::Values start = grey();
    TexelFit fit(pages);
    const auto wanted = [](double x, double y) {
        return static_cast<float>(0.5 + 0.3 * std::sin(0.5 * x) * std::cos(0.4 * y));
    };
    for (std::size_t i = 0; i < start[0].size(); ++i) fit.add_prior(0, i, 1e-3F);
    for (int j = 2; j < 2 * kSide - 4; ++j)
        for (int i = 2; i < 2 * kSide - 4; ++i) {
            const Vec2d p{0.5 * i + 0.25, 0.5 * j + 0.25};
            const float c = wanted(p.x, p.y);
            fit.add_sample(*fit.tap(0, p), {c, c, c}, 0.25F);
        }
    const TexelFit::Values out = fit.solve(start, {});
    for (double y = 2.0; y < kSide - 3; y += 0.37)
        for (double x = 2.0; x < kSide - 3; x += 0.41)
            EXPECT_NEAR(read(out, x, y), wanted(x, y), 0.012);
}

TEST(TexelFit, PairsComeToShowTheSame) {
    const std::vector<PageSize> pages{{kSide, kSide}};
    TexelFit::Values start = grey();
    for (std::size_t i = 0; i < start[0].size(); ++i)
        if (i % kSide >= kSide / 2) start[0][i] = {0.9F, 0.9F, 0.9F};
    TexelFit fit(pages);
    for (std::size_t i = 0; i < start[0].size(); ++i) fit.add_prior(0, i, 1.0F);
    // Two borders, two columns of places.
    for (int k = 0; k < 20; ++k) {
        const double y = 1.0 + 0.6 * k;
        fit.add_pair(*fit.tap(0, {3.3, y}), *fit.tap(0, {11.6, y}), 64.0F);
    }
    const TexelFit::Values out = fit.solve(start, {});
    for (int k = 0; k < 20; ++k) {
        const double y = 1.0 + 0.6 * k;
        EXPECT_NEAR(read(out, 3.3, y), read(out, 11.6, y), 0.016);
    }
    // Away from them nothing has changed.
    EXPECT_FLOAT_EQ(read(out, 7.0, 7.5), 0.5F);
}

TEST(TexelFit, KnowsNoTexelsBeyondThePage) {
    const std::vector<PageSize> pages{{kSide, kSide}};
    const TexelFit fit(pages);
    EXPECT_FALSE(fit.tap(0, {-0.1, 3.0}));
    EXPECT_FALSE(fit.tap(0, {3.0, kSide - 0.9}));
    const std::vector<PageSize> narrow{{1, kSide}};
    EXPECT_FALSE(TexelFit(narrow).tap(0, {0.0, 3.0}));
}

TEST(TexelFit, ReachesTheLastRowAndColumn) {
    // Patches touch the sides of their page.
    const std::vector<PageSize> pages{{kSide, kSide}};
    TexelFit::Values start = grey();
    for (int j = 0; j < kSide; ++j) start[0][static_cast<std::size_t>(kSide * j)] = {0.9F, 0, 0};
    TexelFit fit(pages);
    for (std::size_t i = 0; i < start[0].size(); ++i) fit.add_prior(0, i, 1.0F);
    for (int y = 0; y < kSide; ++y)
        fit.add_pair(*fit.tap(0, {0.0, 1.0 * y}), *fit.tap(0, {kSide - 1.0, 1.0 * y}), 64.0F);
    // Three quarters of the way between two texels of the last row.
    const auto low = *fit.tap(0, {6.75, kSide - 1.0});
    EXPECT_EQ(low.first, static_cast<std::size_t>((kSide - 2) * kSide + 6));
    EXPECT_EQ(low.weights, (std::array<float, 4>{0.0F, 0.0F, 0.25F, 0.75F}));
    fit.add_pair(low, *fit.tap(0, {6.75, 0.0}), 64.0F);
    const TexelFit::Values out = fit.solve(start, {});
    for (int y = 0; y < kSide; ++y)
        EXPECT_NEAR(out[0][static_cast<std::size_t>(kSide * y)].x,
                    out[0][static_cast<std::size_t>(kSide * y + kSide - 1)].x, 0.01);
}

}  // namespace
}  // namespace pointbake
