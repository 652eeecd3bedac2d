#include "sample/color_source.h"

#include <gtest/gtest.h>

#include "core/color.h"

namespace pointbake {
namespace {

/// An image whose texel (x, y) has the grey value of value(x, y).
template <class F>
Image grey_image(int width, int height, F&& value) {
    Image image{width, height, 3, {}};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (int k = 0; k < 3; ++k)
                image.pixels.push_back(static_cast<std::uint8_t>(value(x, y)));
    return image;
}

/// Half the unit square, textured from edge to edge: texel (i, j) of an n x n image is 1/n large.
TexturedMesh textured_triangle(Image image, float repeats = 1.0F) {
    TexturedMesh model;
    model.mesh.positions = {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}};
    model.mesh.triangles = {{0, 1, 2}};
    model.mesh.uvs = {{Vec2f{0.0F, 0.0F}, Vec2f{repeats, 0.0F}, Vec2f{0.0F, repeats}}};
    model.materials.push_back({.color_image = 0});
    model.images.push_back(std::move(image));
    return model;
}

Rgb16 grey(int v) {
    const auto c = static_cast<std::uint8_t>(v);
    return rgb16_from_8bit(c, c, c);
}

/// Within one step of 65535.
void expect_near(Rgb16 a, Rgb16 b) {
    EXPECT_NEAR(a.r, b.r, 1.0);
    EXPECT_NEAR(a.g, b.g, 1.0);
    EXPECT_NEAR(a.b, b.b, 1.0);
}

TEST(ColorSource, HalvesImagesInLinearLight) {
    const auto mips =
        make_mips(grey_image(4, 4, [](int x, int y) { return (x + y) % 2 ? 255 : 0; }), {});
    ASSERT_EQ(mips.size(), 3U);
    for (const auto& texel : mips[1].texels) EXPECT_NEAR(texel[0], 65535.0 * std::sqrt(0.5), 1.0);
    EXPECT_EQ(mips[2].width, 1);
}

TEST(ColorSource, KeepsTheMeanOfImagesWithOddSides) {
    const auto mips = make_mips(grey_image(5, 3, [](int x, int y) { return 17 * x + 40 * y; }), {});
    double mean = 0.0;
    for (const auto& texel : mips[0].texels) mean += texel[1] * (texel[1] / 15.0);
    EXPECT_EQ(mips[1].width, 2);
    EXPECT_EQ(mips[1].height, 1);
    EXPECT_NEAR(mips[2].texels[0][1], std::sqrt(mean), 1.0);
}

TEST(ColorSource, GivesTheTexelsOwnCodeAtItsCenter) {
    const TexturedMesh model =
        textured_triangle(grey_image(8, 8, [](int x, int y) { return 10 + 20 * x + 3 * y; }));
    const ColorSource source(model, {});
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x)
            expect_near(source.color({0, 0.0F, (x + 0.5) / 8.0, (y + 0.5) / 8.0}, 0.01),
                        grey(10 + 20 * x + 3 * y));
}

TEST(ColorSource, TakesTheLevelWhoseTexelsAreAtMostTheSpacing) {
    // Level l: 2^l / 16. A checkerboard is grey from level 1 on.
    const TexturedMesh model =
        textured_triangle(grey_image(16, 16, [](int x, int y) { return (x + y) % 2 ? 255 : 0; }));
    const ColorSource source(model, {});
    const SurfaceSample place{0, 0.0F, 4.5 / 16.0, 4.5 / 16.0};
    EXPECT_EQ(source.color(place, 0.124).r, 0);
    EXPECT_NEAR(source.color(place, 0.126).r, 65535.0 * linear_to_srgb_exact(0.5), 2.0);
}

TEST(ColorSource, RepeatsTextures) {
    const auto image = grey_image(4, 4, [](int x, int y) { return 60 * x + 4 * y; });
    const TexturedMesh once = textured_triangle(image), thrice = textured_triangle(image, 3.0F);
    const ColorSource a(once, {}), b(thrice, {});
    const double u = 0.375 / 3.0, v = 0.125 / 3.0;
    const Rgb16 first = b.color({0, 0.0F, u, v}, 0.01);
    EXPECT_EQ(first, a.color({0, 0.0F, 0.375, 0.125}, 0.01));
    // Across the seam: halfway between the last column and the first.
    const Rgb16 seam = b.color({0, 0.0F, 1.0 / 3.0, v}, 0.01);
    const double mean = 0.5 * (srgb_to_linear_exact(0.0) + srgb_to_linear_exact(180.0 / 255.0));
    EXPECT_NEAR(seam.r, 65535.0 * linear_to_srgb_exact(mean), 4.0);
    EXPECT_NEAR(b.color({0, 0.0F, u + 1.0 / 3.0, v + 1.0 / 3.0}, 0.01).r, first.r, 1.0);
}

TEST(ColorSource, ReadsGreyImagesWithAlpha) {
    Image image{2, 2, 2, {50, 255, 50, 0, 50, 9, 50, 255}};
    const TexturedMesh model = textured_triangle(image);
    expect_near(ColorSource(model, {}).color({0, 0.0F, 0.3, 0.3}, 0.1), grey(50));
}

TEST(ColorSource, FallsBackToVertexColorsAndThenToTheMaterial) {
    TexturedMesh model = textured_triangle(grey_image(2, 2, [](int, int) { return 77; }));
    model.materials[0].color_image = -1;
    model.materials[0].base_color = {1.0, 0.5, 0.0};
    const SurfaceSample middle{0, 0.0F, 1.0 / 3.0, 1.0 / 3.0};
    const Rgb16 plain = ColorSource(model, {}).color(middle, 0.1);
    EXPECT_EQ(plain.r, 65535);
    EXPECT_NEAR(plain.g, 65535.0 * linear_to_srgb_exact(0.5), 1.0);
    EXPECT_EQ(plain.b, 0);

    model.materials.clear();
    EXPECT_FALSE(ColorSource(model, {}).has_colors());
    model.mesh.colors = {{65535, 0, 0}, {0, 65535, 0}, {0, 0, 65535}};
    EXPECT_TRUE(ColorSource(model, {}).has_colors());
    const Rgb16 mixed = ColorSource(model, {}).color(middle, 0.1);
    EXPECT_NEAR(mixed.r, 65535.0 * linear_to_srgb_exact(1.0 / 3.0), 1.0);
    EXPECT_EQ(mixed.r, mixed.b);
}

}  // namespace
}  // namespace pointbake
