#include <gtest/gtest.h>

#include <cmath>

#include "core/adjacency.h"
#include "core/bvh.h"
#include "model/demo_shape.h"
#include "pointbake/model.h"

namespace pointbake {
namespace {

using M = DemoMeasures;

// Contouring takes a few tenths of a second: once for all tests.
const Mesh& model() {
    static const Mesh mesh = demo_mesh();
    return mesh;
}

const TriangleBvh& tree() {
    static const TriangleBvh bvh(model().positions, model().triangles);
    return bvh;
}

// How thick the solid is where a ray enters it.
double thickness(Vec3d origin, Vec3d direction) {
    const auto in = tree().first_hit(origin, direction);
    if (!in) return 0.0;
    const Vec3d entry = origin + direction * (in->t + 1e-6);
    const auto out = tree().first_hit(entry, direction);
    return out ? out->t : 0.0;
}

TEST(DemoMesh, IsAClosedManifoldWithOneHandle) {
    const Topology t = topology(model().positions.size(), model().triangles);
    EXPECT_TRUE(t.is_closed_manifold());
    EXPECT_EQ(t.num_components, 1U);
    EXPECT_EQ(t.euler(), 0);
    EXPECT_EQ(t.num_vertices, model().positions.size());
    EXPECT_GT(t.num_triangles, 50'000U);
    EXPECT_LT(t.num_triangles, 200'000U);
    EXPECT_NEAR(volume(model().positions, model().triangles), 1.81, 0.01);
}

TEST(DemoMesh, FillsItsBox) {
    Box box;
    for (const Vec3d& p : model().positions) box.extend(p);
    EXPECT_NEAR(length(box.low - Vec3d{-1.0, 0.0, -0.7}), 0.0, 1e-9);
    EXPECT_NEAR(length(box.high - Vec3d{1.0, box.high.y, 0.7}), 0.0, 1e-9);
    EXPECT_NEAR(box.high.y, 1.531, 0.002);
}

TEST(DemoMesh, LiesOnTheShape) {
    double worst = 0.0, mean = 0.0;
    for (const Vec3d& p : model().positions) {
        const double off = std::abs(demo_shape(p));
        worst = std::max(worst, off);
        mean += off / static_cast<double>(model().positions.size());
    }
    EXPECT_LT(worst, 2e-3);
    EXPECT_LT(mean, 1e-6);
}

TEST(DemoMesh, HasSharpEdgesAndCorners) {
    int on_edge = 0, on_corner = 0;
    for (const Vec3d& p : model().positions) {
        if (std::abs(p.x - 1.0) + std::abs(p.z - 0.7) > 1e-9) continue;
        ++on_edge;
        if (std::abs(p.y) < 1e-9 || std::abs(p.y - 0.1) < 1e-9) ++on_corner;
    }
    EXPECT_GE(on_edge, 6);  // the vertical edge is 0.1 long: a vertex per cell
    EXPECT_EQ(on_corner, 2);
}

TEST(DemoMesh, HasAThinHandleAndAThinLeaf) {
    // 3.4 and 3.5 % of the size.
    EXPECT_NEAR(thickness({-2.0, M::pot.y + 0.03, M::pot.z}, {1.0, 0.0, 0.0}), 2.0 * M::handle_tube,
                0.003);
    EXPECT_NEAR(thickness({M::leaf.x + 0.12, 1.4, M::leaf.z + 0.12}, {0.0, -1.0, 0.0}),
                M::leaf_thickness * 1.108, 0.003);  // its slope there is 0.475
}

TEST(DemoMesh, HasASaddle) {
    const auto height = [&](double dx, double dz) {
        const Vec3d above{M::leaf.x + dx, 1.4, M::leaf.z + dz};
        const auto hit = tree().first_hit(above, {0.0, -1.0, 0.0});
        return hit ? 1.4 - hit->t : 0.0;
    };
    EXPECT_GT(height(0.15, 0.0), height(0.0, 0.0) + 0.02);
    EXPECT_GT(height(-0.15, 0.0), height(0.0, 0.0) + 0.02);
    EXPECT_LT(height(0.0, 0.15), height(0.0, 0.0) - 0.02);
    EXPECT_LT(height(0.0, -0.15), height(0.0, 0.0) - 0.02);
}

TEST(DemoMesh, HasAMushroomThatOverhangs) {
    // Beside the stem, under the cap: a ray downwards enters the cap, leaves it, meets the plinth.
    const Vec3d above{M::mushroom.x + 0.22, 1.4, M::mushroom.z};
    const double cap = thickness(above, {0.0, -1.0, 0.0});
    const auto in = tree().first_hit(above, {0.0, -1.0, 0.0});
    ASSERT_TRUE(in);
    const double under = 1.4 - in->t - cap;
    EXPECT_GT(under, M::top + 0.2);
    EXPECT_LT(cap, 0.3);
}

}  // namespace
}  // namespace pointbake
