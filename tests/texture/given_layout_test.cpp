#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "pointbake/error.h"
#include "texture/planes.h"

namespace pointbake {
namespace {

constexpr std::int64_t kNoBudget = std::numeric_limits<std::int64_t>::max();

Vec3d wave(double x, double y) {
    return {0.5 + 0.3 * std::sin(12.0 * x), 0.5 + 0.3 * std::cos(9.0 * y),
            0.5 + 0.2 * std::sin(8.0 * (x + y))};
}

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

GivenBake bake(const Painted& p, const GivenLayout& layout, double bound,
               std::int64_t texels = kNoBudget) {
    TextureOptions options;
    options.keep_uvs = true;
    return TextureBaker(p.mesh, p.cloud, p.owners, options, {})
        .bake_given(layout, bound, texels, 4096, {});
}

double rms_against_wave(const TexturedMesh& model) {
    double sum = 0.0;
    int count = 0;
    for (int j = 1; j < 50; ++j) {
        for (int i = 1; i < 50; ++i) {
            const double x = i / 50.0, y = j / 50.0;
            const Index t = y <= x ? 0 : 1;
            const Vec3d b = t == 0 ? Vec3d{1 - x, x - y, y} : Vec3d{1 - y, x, y - x};
            sum += squared_length(color_at(model, t, b) - wave(x, y) * 255.0) / 3.0;
            ++count;
        }
    }
    return std::sqrt(sum / count);
}

TEST(GivenLayout, KeepsTheTextureCoordinatesAndTheBound) {
    const Painted p = laid_out_square();
    const GivenBake out = bake(p, kOnePage, 0.7);
    EXPECT_EQ(out.texture.model.mesh.uvs, p.mesh.uvs);
    EXPECT_EQ(out.texture.model.materials.at(0).name, "paint");
    EXPECT_TRUE(out.report.bound_met);
    EXPECT_LE(out.report.error_max, 0.7);
    EXPECT_LT(rms_against_wave(out.texture.model), 1.0);
    EXPECT_EQ(out.num_shared_texels, 0U);
    EXPECT_LT(bake(p, kOnePage, 8.0).pages.at(0).width, out.pages.at(0).width)
        << "the smallest page that keeps the bound";
}

TEST(GivenLayout, PagesKeepTheBudgetAndTheirProportions) {
    const Painted p = laid_out_square();
    const GivenLayout layout{{{"left", {200, 100}}, {"right", {100, 100}}}, {0, 1}};
    const GivenBake out = bake(p, layout, 0.0, 12'500);
    ASSERT_EQ(out.pages.size(), 2U);
    EXPECT_NEAR(static_cast<double>(out.pages[0].width) / out.pages[0].height, 2.0, 0.4);
    EXPECT_EQ(out.pages[1].width, out.pages[1].height);
    const int total =
        out.pages[0].width * out.pages[0].height + out.pages[1].width * out.pages[1].height;
    EXPECT_LE(total, 12'500);
    EXPECT_GE(total, 11'250);
    EXPECT_FALSE(out.report.bound_met);
    EXPECT_GT(out.report.capped.by_budget, 0U);
    EXPECT_THROW(bake(p, layout, 0.0, 1000), Error);
}

TEST(GivenLayout, TexelsOfAMirroredLayoutAreCounted) {
    Painted p = laid_out_square();
    p.mesh.uvs[1] = {p.mesh.uvs[0][0], p.mesh.uvs[0][2], p.mesh.uvs[0][1]};
    EXPECT_GT(bake(p, kOnePage, 4.0).num_shared_texels, 100U);
}

TEST(GivenLayout, PagesRepeatWhereTheLayoutLeavesThem) {
    const Painted p = laid_out_square(0.6, 1.4);
    const GivenBake out = bake(p, kOnePage, 2.0);
    EXPECT_TRUE(out.texture.model.images.at(0).repeats);
    // What lies at (1.2, 1.2) is read at (0.2, 0.2).
    const Image& page = out.texture.model.images[0];
    const auto i = static_cast<std::size_t>(0.2 * page.width);
    const std::uint8_t* texel = &page.pixels[3 * (i * static_cast<std::size_t>(page.width) + i)];
    const double at = ((static_cast<double>(i) + 0.5) / page.width + 1.0 - 0.6) / 0.8;
    const Vec3d wanted = wave(at, at) * 255.0;
    EXPECT_NEAR(texel[0], wanted.x, 2.0);
    EXPECT_NEAR(texel[1], wanted.y, 2.0);
    EXPECT_FALSE(bake(laid_out_square(), kOnePage, 2.0).texture.model.images.at(0).repeats);
}

TEST(GivenLayout, MeshWithoutTextureCoordinatesIsRefused) {
    EXPECT_THROW(bake(painted_square(20, wave), kOnePage, 4.0), Error);
    EXPECT_THROW(bake(laid_out_square(0.0, 40.0), kOnePage, 4.0), Error);
}

}  // namespace
}  // namespace pointbake
