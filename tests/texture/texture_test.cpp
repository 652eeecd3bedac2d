#include "pointbake/texture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>

#include "core/hash.h"
#include "pointbake/error.h"
#include "texture/coding.h"
#include "texture/planes.h"
#include "texture/shell.h"

namespace pointbake {
namespace {

constexpr std::int64_t kNoBudget = std::numeric_limits<std::int64_t>::max();

TEST(Texture, ConstantColourCostsOneTexelPerTriangleAndIsExact) {
    const Painted p = painted_square(40, [](double, double) { return Vec3d{0.2, 0.4, 0.8}; });
    const TextureBaker baker(p.mesh, p.cloud, p.owners, kTriangles, {});
    const TexturePlan plan = baker.plan(4.0, kNoBudget);
    EXPECT_EQ(plan.num_needed, 2);
    const BakedTexture baked = bake_apart(baker, plan);
    const Vec3d c = color_at(baked.model, 0, {0.3, 0.3, 0.4});
    EXPECT_NEAR(c.x, 0.2 * 255, 0.51);
    EXPECT_NEAR(c.y, 0.4 * 255, 0.51);
    EXPECT_NEAR(c.z, 0.8 * 255, 0.51);
}

TEST(Texture, LinearRampStaysSmall) {
    const auto ramp = [](double x, double y) { return Vec3d{0.4 + 0.1 * x, 0.4 + 0.1 * y, 0.45}; };
    const Painted p = painted_square(50, ramp);
    const TextureBaker baker(p.mesh, p.cloud, p.owners, kTriangles, {});
    const TexturePlan plan = baker.plan(1.0, kNoBudget);
    EXPECT_LT(plan.num_needed, 200);
    EXPECT_LT(rms_against(bake_apart(baker, plan).model, ramp), 1.5);
}

TEST(Texture, MeetsItsBoundAgainstTheTruth) {
    const Painted p = painted_square(80, wave);
    const TextureBaker baker(p.mesh, p.cloud, p.owners, kTriangles, {});
    const TexturePlan plan = baker.plan(2.0, kNoBudget);
    const TextureReport report = bake_apart(baker, plan, 2.0).report;
    EXPECT_TRUE(report.bound_met);
    EXPECT_LE(report.error_max, 2.0);
    EXPECT_LT(rms_against(bake_apart(baker, plan).model, wave), 2.5);
}

TEST(Texture, FlatTrianglesCostNextToNothingBesideLettering) {
    // [Wicke05]'s bee: strokes on one triangle, away from the edge that it shares with the other.
    const Painted p = painted_square(100, [](double x, double y) {
        const bool is_stroke = y > x + 0.15 && std::sin(60.0 * x) * std::sin(60.0 * y) > 0.0;
        return is_stroke ? Vec3d{0.05, 0.05, 0.05} : Vec3d{0.2, 0.5, 0.9};
    });
    const TextureBaker baker(p.mesh, p.cloud, p.owners, kTriangles, {});
    const TexturePlan plan = baker.plan(4.0, kNoBudget);
    EXPECT_LE(plan.shapes[0].num_texels(), 8);
    EXPECT_GE(plan.shapes[1].num_texels(), 200);
}

TEST(Texture, CoarseTexelsAverageLinearLight) {
    const Painted p = painted_square(80, [](double x, double y) {
        const double v = (static_cast<int>(x * 80) + static_cast<int>(y * 80)) % 2;
        return Vec3d{v, v, v};
    });
    const TextureBaker baker(p.mesh, p.cloud, p.owners, kTriangles, {});
    const TexturePlan plan = baker.plan(HUGE_VAL, 2);
    ASSERT_EQ(plan.num_needed, 2);
    // Half the light; half the code would be 128.
    EXPECT_NEAR(color_at(bake_apart(baker, plan).model, 0, {0.3, 0.3, 0.4}).x, 187.5, 3.0);
}

TEST(Texture, WhatIsWhiterThanWhiteCountsAsWhite) {
    // Sharpening overshoots beside edges; no texel can show it.
    EXPECT_EQ(to_steps(MapKind::kColor, {1.2F, -0.1F, 0.5F}), (Vec3f{255.0F, 0.0F, 127.5F}));
}

TEST(Texture, FineTexelsInterpolateCodes) {
    const Painted p = painted_square(
        16, [](double x, double) { return x < 0.5 ? Vec3d{0, 0, 0} : Vec3d{1, 1, 1}; });
    const TextureBaker baker(p.mesh, p.cloud, p.owners, kTriangles, {});
    const BakedTexture baked = bake_apart(baker, baker.plan(1.0, kNoBudget));
    // Midway between the last black points and the first white ones; in linear light it is 188.
    EXPECT_NEAR(color_at(baked.model, 0, {0.5, 0.25, 0.25}).x, 127.5, 15.0);
}

TEST(Texture, SharpeningBringsBackWhatSplattingSmooths) {
    // A wave as long as 5 points: the splats alone are 8.6 steps off.
    const auto fine = [](double x, double y) {
        const double c = 0.5 + 0.3 * std::sin(80.0 * x) * std::cos(20.0 * y);
        return Vec3d{c, c, c};
    };
    const Painted p = painted_square(64, fine);
    const TextureBaker baker(p.mesh, p.cloud, p.owners, kTriangles, {});
    EXPECT_LT(rms_against(bake_apart(baker, baker.plan(1.0, kNoBudget)).model, fine), 5.0);
}

TEST(Texture, SharpensByWhatPredictsBest) {
    const auto rounds = [](const std::function<Vec3d(double, double)>& paint) {
        const Painted p = painted_square(64, paint);
        const TextureBaker baker(p.mesh, p.cloud, p.owners, kTriangles, {});
        return bake_apart(baker, baker.plan(4.0, kNoBudget)).report.sharpening_rounds;
    };
    EXPECT_GE(rounds(wave), 3);
    std::uint64_t draws = 0;
    const auto noise = [&](double, double) {
        const double v = 0.4 + 0.2 * random_unit(1, draws++);
        return Vec3d{v, v, v};
    };
    EXPECT_EQ(rounds(noise), 0);
}

TEST(Texture, TighterBoundNeverNeedsFewerTexels) {
    const Painted p = painted_square(60, wave);
    const TextureBaker baker(p.mesh, p.cloud, p.owners, kTriangles, {});
    std::int64_t before = 0;
    for (double bound : {16.0, 8.0, 4.0, 2.0, 1.0}) {
        const std::int64_t needed = baker.plan(bound, kNoBudget).num_needed;
        EXPECT_GE(needed, before) << "bound " << bound;
        before = needed;
    }
}

TEST(Texture, PlansAreTheSameWhereTheBoundIsKnownBefore) {
    const Painted p = painted_square(80, wave);
    for (const double bound : {1.0, 4.0}) {
        TextureOptions options = kTriangles;
        options.texture_error = bound;  // nothing finer is measured
        const TextureBaker some(p.mesh, p.cloud, p.owners, options, {}),
            all(p.mesh, p.cloud, p.owners, kTriangles, {});
        EXPECT_EQ(some.plan(bound, kNoBudget).levels, all.plan(bound, kNoBudget).levels);
        EXPECT_GT(all.plan(0.5, kNoBudget).num_needed, all.plan(bound, kNoBudget).num_needed);
    }
}

TEST(Texture, NeverNeedsMoreThanTheBudget) {
    const Painted p = painted_square(80, wave);
    const TextureBaker baker(p.mesh, p.cloud, p.owners, kTriangles, {});
    for (std::int64_t budget : {50, 200, 1000, 4000}) {
        EXPECT_LE(baker.plan(HUGE_VAL, budget).num_needed, budget);
    }
}

TEST(Texture, BothSidesOfAnEdgeShowTheSameColour) {
    const Painted p = painted_square(80, wave);
    const TextureBaker baker(p.mesh, p.cloud, p.owners, kTriangles, {});
    const TexturedMesh model = bake_apart(baker, baker.plan(1.0, kNoBudget)).model;
    for (double s = 0.05; s < 1.0; s += 0.1) {
        const Vec3d a = color_at(model, 0, {1 - s, 0.0, s}),
                    b = color_at(model, 1, {1 - s, s, 0.0});
        EXPECT_LT(length(a - b), 6.0) << "at " << s;
    }
}

TEST(Texture, ScalingTheModelChangesNothing) {
    Painted p = painted_square(40, wave);
    const TextureBaker small(p.mesh, p.cloud, p.owners, kTriangles, {});
    const BakedTexture a = bake_apart(small, small.plan(3.0, kNoBudget));
    Painted q = p;
    for (Vec3d& x : q.mesh.positions) x = x * 1024.0;
    for (Vec3d& x : q.cloud.positions) x = x * 1024.0;
    for (float& x : q.cloud.areas) x *= 1024.0F * 1024.0F;
    const TextureBaker large(q.mesh, q.cloud, q.owners, kTriangles, {});
    const BakedTexture b = bake_apart(large, large.plan(3.0, kNoBudget));
    ASSERT_EQ(a.model.images.size(), b.model.images.size());
    for (std::size_t i = 0; i < a.model.images.size(); ++i)
        EXPECT_EQ(a.model.images[i].pixels, b.model.images[i].pixels);
}

TEST(Texture, AChartShowsTheTruth) {
    const Painted p = painted_square(80, wave);
    const TextureBaker baker(p.mesh, p.cloud, p.owners, {}, {});
    const TexturePlan plan = baker.plan(2.0, kNoBudget);
    ASSERT_EQ(plan.shapes.size(), 1U) << "two triangles in a plane are one chart";
    const BakedTexture baked = bake_apart(baker, plan, 2.0);
    EXPECT_TRUE(baked.report.bound_met);
    EXPECT_LE(baked.report.error_max, 2.0);
    EXPECT_LE(baked.report.largest_stretch, 1.0001);
    EXPECT_LT(rms_against(baked.model, wave), 2.5);
    EXPECT_TRUE(baked.model.images[0].has_mips);
    double share = 0.0;
    for (const TextureReport::Density& d : baked.report.densities) share += d.area_share;
    EXPECT_NEAR(share, 1.0, 1e-9);
}

TEST(Texture, FlatPaintIsCutOffFromLetteringInOneChart) {
    // Lettering on the lower right triangle alone.
    const Painted p = painted_square(100, [](double x, double y) {
        const bool is_stroke = y < x - 0.1 && std::sin(60.0 * x) * std::sin(60.0 * y) > 0.0;
        return is_stroke ? Vec3d{0.05, 0.05, 0.05} : Vec3d{0.2, 0.5, 0.9};
    });
    TextureOptions options;
    const TextureBaker whole(p.mesh, p.cloud, p.owners, options, {});
    const TexturePlan one = whole.plan(4.0, kNoBudget);
    options.texture_error = 4.0;
    const TextureBaker cut(p.mesh, p.cloud, p.owners, options, {});
    const TexturePlan two = cut.plan(4.0, kNoBudget);
    ASSERT_EQ(one.shapes.size(), 1U);
    ASSERT_EQ(two.shapes.size(), 2U);
    EXPECT_LT(two.num_needed, 0.7 * static_cast<double>(one.num_needed));
    // A texel or two of the flat part reach over its border: finer ones, and all is well.
    const BakedTexture baked = bake_apart(cut, two, 4.0);
    const std::optional<TexturePlan> finer = cut.refined(two, 4.0, baked);
    ASSERT_TRUE(finer);
    EXPECT_LT(finer->num_needed, 0.7 * static_cast<double>(one.num_needed));
    EXPECT_LE(bake_apart(cut, *finer, 4.0).report.capped.total(),
              bake_apart(whole, one, 4.0).report.capped.total());
}

TEST(Texture, PatchesThatMissTheirBoundAreMadeFiner) {
    const Painted p = painted_square(80, wave);
    for (const TextureOptions& options : {kTriangles, TextureOptions{}}) {
        const TextureBaker baker(p.mesh, p.cloud, p.owners, options, {});
        const TexturePlan first = baker.plan(6.0, kNoBudget);
        BakedTexture baked = bake_apart(baker, first, 6.0);
        ASSERT_EQ(baked.is_missed, std::vector<std::uint8_t>(2, 0));
        EXPECT_FALSE(baker.refined(first, 6.0, baked));
        baked.is_missed[1] = 1;
        TexturePlan plan = first;
        for (int round = 0; round < 40; ++round) {
            const std::optional<TexturePlan> next = baker.refined(plan, 6.0, baked);
            if (!next) break;
            const std::size_t missed = plan.levels.size() - 1;
            EXPECT_GT(next->levels[missed], plan.levels[missed]);
            if (missed == 1) {
                EXPECT_EQ(next->levels[0], first.levels[0]);
            }
            plan = *next;
        }
        EXPECT_FALSE(baker.refined(plan, 6.0, baked)) << "no end";
        EXPECT_GT(plan.num_needed, 2 * first.num_needed);
    }
}

TEST(Texture, ChartsFillTheirGutters) {
    const Painted p = painted_square(40, wave);
    TextureOptions wide;
    wide.mips = 3;
    const TextureBaker narrow(p.mesh, p.cloud, p.owners, {}, {}),
        baker(p.mesh, p.cloud, p.owners, wide, {});
    const TexturePlan a = narrow.plan(3.0, kNoBudget), b = baker.plan(3.0, kNoBudget);
    // 4 and 8 texels around it.
    EXPECT_EQ(b.shapes[0].width() - a.shapes[0].width(), 8);
    const BakedTexture baked = bake_apart(baker, b);
    const auto owned = std::accumulate(baked.owned[0].begin(), baked.owned[0].end(), 0);
    EXPECT_EQ(owned, b.shapes[0].num_texels());
}

TEST(Texture, CoarseTexelsFitWhatIsBetweenThem) {
    // Texels of two points' width: sampled at their centres they would flatten the waves.
    const auto fine = [](double x, double y) {
        const double v = 0.5 + 0.25 * std::sin(40.0 * x) * std::sin(40.0 * y);
        return Vec3d{v, v, v};
    };
    const Painted p = painted_square(60, fine);
    const TextureBaker baker(p.mesh, p.cloud, p.owners, {}, {});
    const BakedTexture baked = bake_apart(baker, baker.plan(HUGE_VAL, 1600));
    EXPECT_LT(rms_against(baked.model, fine), 7.0);
}

// [Wicke05], Figure 3: a saddle on two triangles that meet in a ridge. Projected along the normals
// of the triangles, points on the ridge's sides fall apart.
Painted saddle() {
    Painted out;
    constexpr double kHeight = 0.6;
    out.mesh.positions = {{1, 0, kHeight}, {0, 1, -kHeight}, {-1, 0, kHeight}, {0, -1, -kHeight}};
    out.mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    constexpr int kSide = 80;
    for (int j = 0; j < kSide; ++j)
        for (int i = 0; i < kSide; ++i) {
            const double u = (i + 0.5) / kSide, v = (j + 0.5) / kSide;
            const double x = u - v, y = u + v - 1.0;  // over the diamond between the corners
            out.cloud.positions.push_back({x, y, kHeight * (x * x - y * y)});
            const Vec3d n = normalized(Vec3d{-2.0 * kHeight * x, 2.0 * kHeight * y, 1.0});
            out.cloud.normals.push_back(vec_cast<float>(n));
            const auto code = static_cast<std::uint16_t>(65535.0 * (0.5 + 0.4 * x));
            out.cloud.colors.push_back({code, code, 30000});
            out.cloud.areas.push_back(static_cast<float>(2.0 / (kSide * kSide) / n.z));
            out.cloud.rows.push_back(out.cloud.rows.size());
            out.owners.push_back(y >= 0.0 ? 0 : 1);
        }
    return out;
}

TEST(Texture, TheSaddleLeavesNoTexelUncovered) {
    const Painted p = saddle();
    for (const AtlasKind atlas : {AtlasKind::kTriangles, AtlasKind::kCharts}) {
        TextureOptions options;
        options.atlas = atlas;
        const TextureBaker baker(p.mesh, p.cloud, p.owners, options, {});
        const BakedTexture baked = bake_apart(baker, baker.plan(1.0, kNoBudget));
        EXPECT_EQ(baked.report.num_uncovered_texels, 0U);
        options.projection = Projection::kOrthographic;
        const TextureBaker papers(p.mesh, p.cloud, p.owners, options, {});
        EXPECT_GT(bake_apart(papers, papers.plan(1.0, kNoBudget)).report.num_uncovered_texels, 0U);
    }
}

TEST(Texture, SameBytesForAnyNumberOfThreads) {
    const Painted p = painted_square(60, wave);
    const Context one{.threads = 1}, seven{.threads = 7};
    const TextureBaker a(p.mesh, p.cloud, p.owners, kTriangles, one),
        b(p.mesh, p.cloud, p.owners, kTriangles, seven);
    const BakedTexture x = bake_apart(a, a.plan(2.0, kNoBudget), 2.0, one),
                       y = bake_apart(b, b.plan(2.0, kNoBudget), 2.0, seven);
    for (std::size_t i = 0; i < x.model.images.size(); ++i)
        EXPECT_EQ(x.model.images[i].pixels, y.model.images[i].pixels);
}

TEST(Texture, TrianglesWithoutPointsTakeTheColourAround) {
    Painted p = painted_square(30, [](double, double) { return Vec3d{0.9, 0.1, 0.1}; });
    for (std::size_t i = 0; i < p.owners.size(); ++i) {
        if (p.owners[i] == 1) p.owners[i] = kInvalidIndex;
    }
    const TextureBaker baker(p.mesh, p.cloud, p.owners, kTriangles, {});
    const BakedTexture baked = bake_apart(baker, baker.plan(4.0, kNoBudget));
    EXPECT_NEAR(color_at(baked.model, 1, {0.2, 0.2, 0.6}).x, 0.9 * 255, 1.0);
}

TEST(Texture, SurfaceThatUnfoldsBackOverATriangleDoesNotColourIt) {
    // Twelve corners of 60 degrees at one vertex: halfway around, the unfolded surface lies over
    // the triangle it started from, and shortly before and after beside it.
    Painted p;
    constexpr int kCorners = 12;
    p.mesh.positions.push_back({0, 0, 0});
    for (int i = 0; i < kCorners; ++i) {
        const double angle = 2.0 * 3.14159265358979 * i / kCorners;
        p.mesh.positions.push_back({std::cos(angle), std::sin(angle), i % 2 ? 0.494 : -0.494});
        p.mesh.triangles.push_back(
            {0, static_cast<Index>(i + 1), static_cast<Index>((i + 1) % kCorners + 1)});
    }
    for (Index t = 0; t < kCorners; ++t) {
        const Triangle& tri = p.mesh.triangles[t];
        const TriangleFrame frame = triangle_frame(p.mesh, t);
        for (int i = 1; i < 12; ++i) {
            for (int j = 1; j < 12 - i; ++j) {
                const double u = i / 12.0, v = j / 12.0;
                p.cloud.positions.push_back(p.mesh.positions[tri[0]] * (1 - u - v) +
                                            p.mesh.positions[tri[1]] * u +
                                            p.mesh.positions[tri[2]] * v);
                p.cloud.colors.push_back(t >= 5 && t <= 7 ? Rgb16{65535, 0, 0}
                                                          : Rgb16{0, 0, 65535});
                p.cloud.normals.push_back(vec_cast<float>(frame.ez));
                p.cloud.areas.push_back(static_cast<float>(frame.area() / 55.0));
                p.cloud.rows.push_back(p.cloud.rows.size());
                p.owners.push_back(t);
            }
        }
    }
    const TextureBaker baker(p.mesh, p.cloud, p.owners, kTriangles, {});
    const BakedTexture baked = bake_apart(baker, baker.plan(4.0, kNoBudget));
    for (Vec3d b : {Vec3d{0.2, 0.4, 0.4}, Vec3d{0.5, 0.5, 0.0}, Vec3d{0.5, 0.0, 0.5}})
        EXPECT_EQ(color_at(baked.model, 0, b).x, 0.0);
    EXPECT_EQ(color_at(baked.model, 6, {0.2, 0.4, 0.4}).x, 255.0);
}

TEST(Texture, NormalMapOfAFlatSquareIsFlat) {
    Painted p = painted_square(30, [](double, double) { return Vec3d{}; });
    p.cloud.colors.clear();
    const TextureBaker baker(p.mesh, p.cloud, p.owners, kTriangles, {});
    const BakedTexture baked = bake_apart(baker, baker.plan(4.0, kNoBudget));
    const Image& page = baked.model.images[0];
    EXPECT_NEAR(page.pixels[0], 128, 1);
    EXPECT_NEAR(page.pixels[1], 128, 1);
    EXPECT_NEAR(page.pixels[2], 255, 1);
}

TEST(Texture, CancelsWhenAsked) {
    const Painted p = painted_square(30, wave);
    std::stop_source source;
    source.request_stop();
    Context context;
    context.stop = source.get_token();
    EXPECT_THROW(TextureBaker(p.mesh, p.cloud, p.owners, kTriangles, context), Error);
}

TEST(Texture, CloudWithoutAreasIsRefused) {
    Painted p = painted_square(10, wave);
    p.cloud.areas.clear();
    EXPECT_THROW(TextureBaker(p.mesh, p.cloud, p.owners, kTriangles, {}), Error);
}

}  // namespace
}  // namespace pointbake
