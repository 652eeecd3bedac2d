#include <gtest/gtest.h>

#include <cmath>
#include <initializer_list>

#include "pointbake/error.h"
#include "texture/planes.h"

namespace pointbake {
namespace {

// The square in the middle of its page, turned by 90 degrees and mirrored.
Painted laid_out_square(double low = 0.1, double high = 0.9) {
    Painted p = painted_square(80, wave);
    for (const Triangle& t : p.mesh.triangles) {
        auto& uv = p.mesh.uvs.emplace_back();
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3d x = p.mesh.positions[t[k]];
            uv[k] = {static_cast<float>(low + (high - low) * x.y),
                     static_cast<float>(low + (high - low) * x.x)};
        }
    }
    return p;
}

const GivenLayout kOnePage{{{"paint", {1, 1}}}, {0, 0}};

// Square pages of one layout.
GivenLimits limits(double bound, std::initializer_list<int> sides, std::size_t num_pages = 1) {
    GivenLimits out{.bound = bound, .sizes = {}, .ends_with_budget = false};
    for (const int side : sides) out.sizes.emplace_back(num_pages, PageSize{side, side});
    return out;
}

GivenBake bake(const Painted& p, const GivenLayout& layout, const GivenLimits& limits,
               const Context& context = {}) {
    TextureOptions options;
    options.keep_uvs = true;
    return TextureBaker(p.mesh, p.cloud, p.owners, options, context)
        .bake_given(layout, limits, context);
}

TEST(GivenLayout, KeepsTheTextureCoordinatesOnTheFirstPagesWithinTheBound) {
    const Painted p = laid_out_square();
    const GivenBake out = bake(p, kOnePage, limits(0.7, {64, 96, 128, 192, 256}));
    EXPECT_EQ(out.texture.model.mesh.uvs, p.mesh.uvs);
    EXPECT_EQ(out.texture.model.materials.at(0).name, "paint");
    EXPECT_TRUE(out.texture.report.bound_met);
    EXPECT_LE(out.texture.report.error_max, 0.7);
    EXPECT_LT(rms_against(out.texture.model, wave), 1.0);
    EXPECT_EQ(out.num_shared_texels, 0U);
    EXPECT_LE(out.texture.report.payload_texels, 0.65 * static_cast<double>(num_texels(out.pages)));
    const int side = out.pages.at(0).width;
    ASSERT_GT(side, 64);
    EXPECT_FALSE(bake(p, kOnePage, limits(0.7, {side - 32})).texture.report.bound_met);
}

TEST(GivenLayout, TheLastPagesCapWhatWantsMore) {
    const Painted p = laid_out_square();
    GivenLimits small = limits(0.4, {32});
    EXPECT_EQ(bake(p, kOnePage, small).texture.report.capped.by_size, 2U);
    small.ends_with_budget = true;
    EXPECT_EQ(bake(p, kOnePage, small).texture.report.capped.by_budget, 2U);
    EXPECT_EQ(bake(p, kOnePage, limits(0.01, {64, 1024})).texture.report.capped.by_spacing, 2U);
    // Rounding alone is more than the bound: larger pages are not tried.
    Painted even = painted_square(80, [](double, double) { return Vec3d{0.2013, 0.2013, 0.2013}; });
    even.mesh.uvs = p.mesh.uvs;
    const GivenBake out = bake(even, kOnePage, limits(0.01, {64, 128}));
    EXPECT_EQ(out.pages.at(0).width, 64);
    EXPECT_EQ(out.texture.report.capped.by_spacing, 2U);
}

TEST(GivenLayout, ATriangleThatShowsAnothersTexelsMissesItsBound) {
    Painted p = laid_out_square();
    p.mesh.uvs[1] = {p.mesh.uvs[0][0], p.mesh.uvs[0][2], p.mesh.uvs[0][1]};
    const GivenBake out = bake(p, kOnePage, limits(4.0, {128}));
    EXPECT_GT(out.num_shared_texels, 1000U);
    EXPECT_EQ(out.texture.report.capped.by_layout, 1U);
    EXPECT_GT(out.texture.report.error_max, 20.0);
    EXPECT_GT(out.texture.report.raw_rms, 10.0);
}

TEST(GivenLayout, ATriangleWithoutAreaIsCountedAndTakesNoTexels) {
    Painted p = laid_out_square();
    p.mesh.uvs[1] = {p.mesh.uvs[0][0], p.mesh.uvs[0][0], p.mesh.uvs[0][0]};
    const GivenBake out = bake(p, kOnePage, limits(4.0, {128}));
    EXPECT_EQ(out.num_without_area, 1U);
    EXPECT_EQ(out.texture.report.capped.by_layout, 1U);
    p.mesh.uvs[0] = p.mesh.uvs[1];
    EXPECT_THROW(bake(p, kOnePage, limits(4.0, {128})), Error);
}

TEST(GivenLayout, PagesRepeatWhereTheLayoutLeavesThem) {
    const Painted p = laid_out_square(0.6, 1.4);
    const GivenBake out = bake(p, kOnePage, limits(2.0, {128}));
    EXPECT_TRUE(out.texture.report.bound_met);
    EXPECT_EQ(out.num_shared_texels, 0U);
    EXPECT_TRUE(out.texture.model.images.at(0).repeats);
    // What lies at (1.2, 1.2) is read at (0.2, 0.2).
    const Image& page = out.texture.model.images[0];
    const auto i = static_cast<std::size_t>(0.2 * page.width);
    const std::uint8_t* texel = &page.pixels[3 * (i * static_cast<std::size_t>(page.width) + i)];
    const double at = ((static_cast<double>(i) + 0.5) / page.width + 1.0 - 0.6) / 0.8;
    const Vec3d wanted = wave(at, at) * 255.0;
    EXPECT_NEAR(texel[0], wanted.x, 2.0);
    EXPECT_NEAR(texel[1], wanted.y, 2.0);
    EXPECT_FALSE(
        bake(laid_out_square(), kOnePage, limits(2.0, {128})).texture.model.images.at(0).repeats);
}

TEST(GivenLayout, APatternThatCoversItsPageManyTimesShowsWhatCameFirst) {
    const GivenBake out = bake(laid_out_square(0.0, 3.0), kOnePage, limits(4.0, {64}));
    EXPECT_EQ(out.num_shared_texels, 64U * 64U);
    // Texel (20, 40) of the first tile shows the place x = v / 3, y = u / 3.
    const std::uint8_t* texel = &out.texture.model.images.at(0).pixels[3 * (40 * 64 + 20)];
    const Vec3d first = wave(40.5 / 64 / 3, 20.5 / 64 / 3) * 255.0;
    EXPECT_NEAR(texel[0], first.x, 4.0);
    EXPECT_NEAR(texel[1], first.y, 4.0);
    EXPECT_EQ(out.texture.report.capped.by_layout, 2U);
    EXPECT_THROW(bake(laid_out_square(0.0, 15.0), kOnePage, limits(4.0, {1024})), Error);
}

TEST(GivenLayout, MirroredNormalMapsHaveTheirHandedness) {
    Painted p = laid_out_square();
    p.cloud.colors.clear();
    const GivenBake mirrored = bake(p, kOnePage, limits(4.0, {64}));
    // +u runs along y, up in the image along -x: z = +1 only with the sign turned.
    EXPECT_EQ(mirrored.texture.model.corner_tangents.at(0), (Vec3f{0.0F, 1.0F, 0.0F}));
    EXPECT_EQ(mirrored.texture.model.tangent_signs.at(0), 1);
    for (auto& uv : p.mesh.uvs)
        for (Vec2f& x : uv) x.x = 1.0F - x.x;
    const GivenBake turned = bake(p, kOnePage, limits(4.0, {64}));
    EXPECT_EQ(turned.texture.model.corner_tangents.at(0), (Vec3f{0.0F, -1.0F, 0.0F}));
    EXPECT_EQ(turned.texture.model.tangent_signs.at(0), -1);
    const Image& page = turned.texture.model.images.at(0);
    const std::uint8_t* middle = &page.pixels[3 * (32 * 64 + 32)];
    EXPECT_NEAR(middle[0], 127.5, 1.0);
    EXPECT_NEAR(middle[1], 127.5, 1.0);
    EXPECT_GE(middle[2], 254);
}

TEST(GivenLayout, SameBytesForAnyNumberOfThreads) {
    const Painted p = laid_out_square();
    Context one, many;
    one.threads = 1;
    many.threads = 7;
    EXPECT_EQ(bake(p, kOnePage, limits(1.0, {128}), one).texture.model.images[0].pixels,
              bake(p, kOnePage, limits(1.0, {128}), many).texture.model.images[0].pixels);
}

TEST(GivenLayout, WhatDoesNotFitTogetherIsRefused) {
    const Painted p = laid_out_square();
    const GivenLimits some = limits(4.0, {64});
    EXPECT_THROW(bake(painted_square(20, wave), kOnePage, some), Error);
    EXPECT_THROW(bake(laid_out_square(0.0, 40.0), kOnePage, some), Error);
    EXPECT_THROW(bake(laid_out_square(0.0, std::nan("")), kOnePage, some), Error);
    EXPECT_THROW(bake(p, {{{"one", {1, 1}}}, {0, 1}}, some), Error);
    EXPECT_THROW(bake(p, {{{"one", {1, 1}}}, {0}}, some), Error);
}

}  // namespace
}  // namespace pointbake
