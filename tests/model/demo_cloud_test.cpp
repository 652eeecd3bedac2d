#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/kdtree.h"
#include "model/darts.h"
#include "model/demo_shape.h"
#include "pointbake/error.h"
#include "pointbake/model.h"
#include "support/shapes.h"

namespace pointbake {
namespace {

constexpr std::uint64_t kCount = 20'000;

const PointCloud& cloud() {
    static const PointCloud points = demo_cloud(kCount);
    return points;
}

double even(Vec3d) { return 1.0; }
double four_to_one(Vec3d p) { return p.x < 0.0 ? 1.0 : 4.0; }

TEST(DemoCloud, HasWhatWasAskedFor) {
    ASSERT_EQ(cloud().size(), kCount);
    ASSERT_EQ(cloud().colors.size(), kCount);
    EXPECT_TRUE(cloud().normals.empty());
    EXPECT_EQ(cloud().num_rows, kCount);
    for (std::uint64_t k = 0; k < kCount; ++k) ASSERT_EQ(cloud().rows[k], k);
}

TEST(DemoCloud, LiesOnTheModel) {
    double worst = 0.0;
    for (const Vec3d& p : cloud().positions) worst = std::max(worst, std::abs(demo_shape(p)));
    EXPECT_LT(worst, 4e-3);  // the mesh's chords cut the tightest curves by that much
}

TEST(DemoCloud, IsFourTimesAsDenseInFront) {
    int front = 0, back = 0;
    for (const Vec3d& p : cloud().positions) {
        if (p.y < 0.11 || p.y > 0.5) continue;
        front += p.z > 0.6499;
        back += p.z < -0.6499;
    }
    ASSERT_GT(back, 200);
    EXPECT_NEAR(static_cast<double>(front) / back, 4.0, 0.3);
}

TEST(DemoCloud, IsTheSameForAnyNumberOfThreads) {
    Context one, seven;
    one.threads = 1;
    seven.threads = 7;
    const PointCloud a = demo_cloud(3000, one), b = demo_cloud(3000, seven);
    EXPECT_EQ(a.positions, b.positions);
    EXPECT_EQ(a.colors, b.colors);
}

TEST(SpreadPoints, CanBeFew) {
    for (const std::uint64_t n : {1U, 2U, 17U})
        EXPECT_EQ(spread_points(shapes::cube_mesh(), &even, n).size(), n);
}

TEST(DemoCloud, RefusesZeroPoints) {
    try {
        demo_cloud(0);
        FAIL() << "made a cloud";
    } catch (const Error& e) {
        EXPECT_EQ(e.code(), ErrorCode::kInvalidOption);
    }
}

TEST(SpreadPoints, LeavesNeitherClumpsNorGaps) {
    const Mesh sphere = shapes::sphere_mesh(12);
    const auto points = spread_points(sphere, &even, 4000);
    ASSERT_EQ(points.size(), 4000U);
    std::vector<Vec3d> positions;
    for (const SurfacePoint& p : points) positions.push_back(p.position);
    const KdTree tree(positions);
    const double unit = std::sqrt(4.0 * 3.14159265 / 4000.0);  // spacing of a square grid
    std::array<Neighbor, 2> nearest;
    for (const Vec3d& p : positions) {
        tree.nearest(p, nearest);
        ASSERT_GT(std::sqrt(nearest[1].squared_distance), 0.7 * unit);
    }
    double gap = 0.0;
    for (std::uint64_t k = 0; k < 20000; ++k) {
        tree.nearest(shapes::fibonacci_direction(k, 20000), std::span(nearest).first(1));
        gap = std::max(gap, std::sqrt(nearest[0].squared_distance));
    }
    EXPECT_LT(gap, 1.3 * unit);
}

TEST(SpreadPoints, FollowsTheDensity) {
    const auto points = spread_points(shapes::cube_mesh(), &four_to_one, 6000);
    const auto right = std::count_if(points.begin(), points.end(),
                                     [](const SurfacePoint& p) { return p.position.x > 0.99; });
    const auto left = std::count_if(points.begin(), points.end(),
                                    [](const SurfacePoint& p) { return p.position.x < -0.99; });
    EXPECT_NEAR(static_cast<double>(right) / static_cast<double>(left), 4.0, 0.35);
}

TEST(SpreadPoints, StopsWhenCancelled) {
    std::stop_source stop;
    stop.request_stop();
    Context context;
    context.stop = stop.get_token();
    EXPECT_THROW(spread_points(shapes::cube_mesh(), &even, 1000, context), Error);
}

}  // namespace
}  // namespace pointbake
