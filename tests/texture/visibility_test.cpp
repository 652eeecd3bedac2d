#include "texture/visibility.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "texture/planes.h"

namespace pointbake {
namespace {

constexpr int kSide = 40;
constexpr double kSpacing = 1.0 / kSide;

void add_point(Painted& p, Vec3d position, Vec3d normal, Index owner) {
    p.cloud.positions.push_back(position);
    p.cloud.normals.push_back(vec_cast<float>(normalized(normal)));
    p.cloud.colors.push_back({0, 0, 65535});
    p.cloud.areas.push_back(static_cast<float>(kSpacing * kSpacing));
    p.cloud.rows.push_back(p.cloud.rows.size());
    p.owners.push_back(owner);
}

Painted red_square() {
    return painted_square(kSide, [](double, double) { return Vec3d{0.8, 0.1, 0.1}; });
}

// The same points again, blue, `depth` spacings below.
Painted with_layer_below(double depth) {
    Painted p = red_square();
    const std::size_t n = p.cloud.size();
    for (std::size_t i = 0; i < n; ++i)
        add_point(p, p.cloud.positions[i] - Vec3d{0.0, 0.0, depth * kSpacing}, {0, 0, 1},
                  p.owners[i]);
    return p;
}

std::size_t num_hidden(const Painted& p) {
    const Context context;
    const auto neighbors = triangle_neighbors(p.mesh.triangles);
    const Shell shell(p.mesh, Projection::kInterpolated, context);
    Footprints prints =
        project_points(p.mesh, p.cloud, p.owners, shell, neighbors, Kernel{}, context);
    hide_covered_in_place(prints, p.cloud, shell, context);
    return static_cast<std::size_t>(
        std::ranges::count_if(prints.items, [](const Footprint& f) { return f.hidden; }));
}

TEST(Visibility, LayerBelowIsNotSeen) {
    const Painted p = with_layer_below(4.0);
    EXPECT_EQ(num_hidden(p), p.cloud.size() / 2);
    const TextureBaker baker(p.mesh, p.cloud, p.owners, kTriangles, {});
    const BakedTexture baked =
        bake_apart(baker, baker.plan(4.0, std::numeric_limits<std::int64_t>::max()));
    const Vec3d c = color_at(baked.model, 0, {0.3, 0.3, 0.4});
    EXPECT_NEAR(c.x, 0.8 * 255, 1.0);
    EXPECT_NEAR(c.z, 0.1 * 255, 1.0);
}

// [Wicke05], Figure 4 (b): simplification has left nothing of a mushroom that stood on the square.
// Its cap, a blue disc with a green underside, lies over the ground; its stem is green.
Painted with_mushroom() {
    constexpr double kRadius = 0.25, kHeight = 0.15, kStem = 0.05;
    Painted p = red_square();
    const auto add_green = [&](Vec3d position, Vec3d normal, Index owner) {
        add_point(p, position, normal, owner);
        p.cloud.colors.back() = {0, 65535, 0};
    };
    const std::size_t n = p.cloud.size();
    for (std::size_t i = 0; i < n; ++i) {
        const Vec3d x = p.cloud.positions[i];
        if (std::hypot(x.x - 0.5, x.y - 0.5) > kRadius) continue;
        add_point(p, x + Vec3d{0, 0, kHeight}, {0, 0, 1}, p.owners[i]);
        add_green(x + Vec3d{0, 0, kHeight - kSpacing}, {0, 0, -1}, p.owners[i]);
    }
    constexpr int kAround = 12;
    for (int k = 0; k < kAround; ++k)
        for (double z = 0.0; z < kHeight - kSpacing; z += kSpacing) {
            const double angle = 2.0 * std::numbers::pi * k / kAround;
            const Vec3d out{std::cos(angle), std::sin(angle), 0.0};
            const Vec3d at = Vec3d{0.5, 0.5, z} + out * kStem;
            add_green(at, out, at.y <= at.x ? 0 : 1);
        }
    return p;
}

TEST(Visibility, NoTexelMixesAMushroomWithTheGroundUnderIt) {
    constexpr double kRadius = 0.25, kRim = 2.5 * kSpacing;
    const Painted p = with_mushroom();
    for (const TextureOptions& options : {kTriangles, TextureOptions{}}) {
        const TextureBaker baker(p.mesh, p.cloud, p.owners, options, {});
        const TexturedMesh model =
            bake_apart(baker, baker.plan(0.0, std::numeric_limits<std::int64_t>::max())).model;
        for (const Index t : {Index{0}, Index{1}})
            for (double u = 0.02; u < 1.0; u += 0.02)
                for (double v = 0.02; u + v < 1.0; v += 0.02) {
                    const Triangle& tri = p.mesh.triangles[t];
                    const Vec3d x = p.mesh.positions[tri[0]] * u + p.mesh.positions[tri[1]] * v +
                                    p.mesh.positions[tri[2]] * (1.0 - u - v);
                    const double r = std::hypot(x.x - 0.5, x.y - 0.5);
                    const Vec3d c = color_at(model, t, {u, v, 1.0 - u - v});
                    if (r < kRadius - kRim) {
                        EXPECT_NEAR(c.z, 255.0, 1.5) << x.x << " " << x.y;
                        EXPECT_NEAR(c.x, 0.0, 1.5) << x.x << " " << x.y;
                    }
                    if (r > kRadius + kRim) {
                        EXPECT_NEAR(c.x, 0.8 * 255, 1.5) << x.x << " " << x.y;
                        EXPECT_NEAR(c.z, 0.1 * 255, 1.5) << x.x << " " << x.y;
                    }
                    // Stem and underside show nowhere: no green but red's own, and what sharpening
                    // adds to it at the rim.
                    EXPECT_LT(c.y, 0.12 * 255) << x.x << " " << x.y;
                }
    }
}

TEST(Visibility, OneSheetHidesNothingOfItself) {
    EXPECT_EQ(num_hidden(red_square()), 0U);
    EXPECT_EQ(num_hidden(with_layer_below(1.0)), 0U) << "nearer than the gap: noise, not a layer";
}

TEST(Visibility, GapsAreMeasuredInSpaceWhereNormalsLean) {
    // A pyramid hangs below the square: its vertex normals lean outwards, and what they
    // interpolate to in the middle is short. There lies the layer.
    for (const double depth : {2.0, 3.5}) {
        Painted p = red_square();
        p.mesh.positions.push_back({0.5, 0.5, -2.0});
        p.mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {1, 0, 4}, {2, 1, 4}, {3, 2, 4}, {0, 3, 4}};
        const std::size_t n = p.cloud.size();
        for (std::size_t i = 0; i < n; ++i) {
            const Vec3d x = p.cloud.positions[i];
            if (std::fabs(x.x - 0.5) < 0.15 && std::fabs(x.y - 0.5) < 0.15)
                add_point(p, x - Vec3d{0.0, 0.0, depth * kSpacing}, {0, 0, 1}, p.owners[i]);
        }
        EXPECT_EQ(num_hidden(p) > 0, depth > 2.5) << depth;
    }
}

TEST(Visibility, OneOutlierHidesNothing) {
    Painted p = red_square();
    add_point(p, {0.7, 0.3, 6.0 * kSpacing}, {0, 0, 1}, 0);
    EXPECT_EQ(num_hidden(p), 0U);
}

TEST(Visibility, TheSidesOfARidgeDoNotHideEachOther) {
    // A roof over the square, its ridge along y: sides at 45 and at 70 degrees.
    for (const double slope : {1.0, 2.7}) {
        Painted p = red_square();
        for (std::size_t i = 0; i < p.cloud.size(); ++i) {
            Vec3d& x = p.cloud.positions[i];
            const double side = x.x < 0.5 ? 1.0 : -1.0;
            x.z = -slope * std::fabs(x.x - 0.5);
            p.cloud.normals[i] = vec_cast<float>(normalized(Vec3d{-side * slope, 0.0, 1.0}));
            p.cloud.areas[i] *= static_cast<float>(std::sqrt(1.0 + slope * slope));
        }
        EXPECT_EQ(num_hidden(p), 0U) << slope;
    }
}

}  // namespace
}  // namespace pointbake
