// What cleaning takes for outliers and floating pieces, and what it must leave alone.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pointbake/clean.h"
#include "support/shapes.h"

namespace pointbake {
namespace {

constexpr std::uint64_t kSeed = 7;

/// Appends n points, uniform in the box.
void add_scattered(PointCloud& cloud, std::uint64_t n, Vec3d low, Vec3d high) {
    for (std::uint64_t i = 0; i < n; ++i) {
        Vec3d p;
        for (std::size_t k = 0; k < 3; ++k)
            p[k] = low[k] + random_unit(kSeed, 3 * i + k) * (high[k] - low[k]);
        shapes::add_point(cloud, p, {0, 1, 0});
    }
}

/// How many of the dropped rows are below `end`, or at least `begin`.
std::uint64_t num_dropped(const CleanResult& result, std::uint64_t begin, std::uint64_t end) {
    return static_cast<std::uint64_t>(std::ranges::count_if(
        result.cloud.dropped,
        [&](const DroppedPoint& point) { return begin <= point.row && point.row < end; }));
}

double sphere_spacing(std::uint64_t n) {
    return std::sqrt(4.0 * std::numbers::pi / static_cast<double>(n));
}

TEST(Outliers, ScatteredOnesGoAndTheSurfaceStays) {
    constexpr std::uint64_t n = 20'000;
    for (const std::uint64_t num_outliers : {n / 100, n / 20}) {
        for (const double noise : {0.0, 0.3}) {
            PointCloud cloud = shapes::sphere_cloud(n, noise * sphere_spacing(n));
            add_scattered(cloud, num_outliers, {-1, -1, -1}, {1, 1, 1});
            std::uint64_t num_far = 0;
            for (std::size_t i = n; i < cloud.size(); ++i)
                num_far +=
                    std::abs(length(cloud.positions[i]) - 1.0) > 4.0 * sphere_spacing(n) ? 1U : 0U;
            const CleanResult result = clean(cloud);
            EXPECT_LE(num_dropped(result, 0, n), n / 1000) << noise;
            EXPECT_GE(1000 * num_dropped(result, n, cloud.size()), 999 * num_far) << noise;
            EXPECT_GT(num_far, num_outliers / 2);
        }
    }
}

/// Distance to the torus of torus_cloud.
double distance_to_torus(Vec3d p) {
    return std::abs(std::hypot(std::hypot(p.x, p.z) - 1.0, p.y) - 0.4);
}

// Some of them have flat neighbourhoods: only what their neighbours are tells.
TEST(Outliers, ThoseBetweenOutliersAndTheSurfaceGoToo) {
    constexpr std::uint64_t n = 20'000;
    constexpr double kArea = 4.0 * std::numbers::pi * std::numbers::pi * 0.4;
    PointCloud scattered;
    add_scattered(scattered, n / 20, {-2.1, -2.1, -2.1}, {2.1, 2.1, 2.1});
    PointCloud cloud = shapes::torus_cloud(n);
    for (const Vec3d& p : scattered.positions)
        if (distance_to_torus(p) > 4.0 * std::sqrt(kArea / n))
            shapes::add_point(cloud, p, {0, 1, 0});
    const CleanResult result = clean(cloud);
    EXPECT_EQ(num_dropped(result, 0, n), 0U);
    EXPECT_EQ(num_dropped(result, n, cloud.size()), cloud.size() - n);
}

TEST(Outliers, OneAboveAPlaneGoesAtFourSpacingsAndStaysAtOne) {
    for (const double height : {1.0, 4.0, 40.0}) {
        PointCloud cloud = shapes::plane_cloud(50, 50, 1.0, 0.3);
        shapes::add_point(cloud, {0.2, height, 0.1}, {0, 1, 0});
        const CleanResult result = clean(cloud);
        ASSERT_EQ(result.report.num_outliers, height > 1.0 ? 1U : 0U) << height;
        EXPECT_EQ(result.report.num_dropped(), result.report.num_outliers);
        if (height > 1.0) {
            EXPECT_EQ(result.cloud.dropped[0].row, 2500U);
            EXPECT_EQ(result.cloud.dropped[0].reason, DropReason::kOutlier);
        }
    }
}

TEST(Outliers, KeepsThemWhenTold) {
    PointCloud cloud = shapes::plane_cloud(50, 50, 1.0, 0.3);
    shapes::add_point(cloud, {0, 9, 0}, {0, 1, 0});
    EXPECT_EQ(clean(cloud, {.outliers = Unwanted::kKeep}).report.num_dropped(), 0U);
}

/// A plane whose right part, beyond x = `edge`, has one point for 16 of the others.
PointCloud jump_cloud(double edge) {
    PointCloud cloud;
    for (std::uint64_t i = 0; i < 40'000; ++i) {
        const Vec3d p{random_unit(1, i), 0.0, random_unit(2, i)};
        if (p.x < edge || random_unit(3, i) < 1.0 / 16.0) shapes::add_point(cloud, p, {0, 1, 0});
    }
    return cloud;
}

TEST(Outliers, SparsePartsBesideDenseOnesStay) {
    for (const double edge : {0.2, 0.5, 0.9}) {
        const PointCloud cloud = jump_cloud(edge);
        EXPECT_LE(clean(cloud).report.num_dropped(), cloud.size() / 1000) << edge;
    }
}

TEST(Outliers, DensityThatFallsWithRangeLosesNothing) {
    PointCloud cloud;  // a scan of the floor: from 3 cm between points to 60 cm
    for (std::uint64_t i = 0; i < 30'000; ++i) {
        const double range = 1.5 * std::pow(20.0, random_unit(1, i));
        const double turn = 2.0 * std::numbers::pi * random_unit(2, i);
        shapes::add_point(cloud, {range * std::cos(turn), 0.0, range * std::sin(turn)}, {0, 1, 0});
    }
    EXPECT_EQ(clean(cloud).report.num_dropped(), 0U);
}

TEST(Outliers, CleanShapesLoseNothing) {
    for (const PointCloud& cloud :
         {shapes::sphere_cloud(5000), shapes::torus_cloud(8000, 1.0, 0.05),
          shapes::plane_cloud(70, 70), shapes::cube_cloud(30), shapes::half_sphere_cloud(3000)})
        EXPECT_EQ(clean(cloud).report.num_dropped(), 0U);
}

/// A sphere of 20 000 points and a ball of n, their surfaces `gap` spacings apart.
PointCloud with_piece(std::uint64_t n, double gap) {
    constexpr std::uint64_t kLarge = 20'000;
    const double spacing = sphere_spacing(kLarge);
    const double radius = spacing * std::sqrt(static_cast<double>(n) / (4.0 * std::numbers::pi));
    PointCloud cloud = shapes::sphere_cloud(kLarge);
    for (const Vec3d p :
         shapes::sphere_cloud(n, 0.0, radius, {1.0 + gap * spacing + radius, 0.0, 0.0}).positions)
        shapes::add_point(cloud, p, {1, 0, 0});
    return cloud;
}

TEST(Floaters, SmallPiecesGoWhole) {
    const CleanResult result = clean(with_piece(19, 12.0));
    ASSERT_EQ(result.report.num_floating, 19U);
    EXPECT_EQ(result.report.num_floating_pieces, 1U);
    EXPECT_EQ(num_dropped(result, 20'000, 20'019), 19U);
    EXPECT_EQ(result.cloud.dropped[0].reason, DropReason::kFloating);
    EXPECT_EQ(clean(with_piece(19, 12.0), {.floaters = Unwanted::kKeep}).report.num_floating, 0U);
}

TEST(Floaters, NeighboursAcrossAGapDoNotJoin) {
    const CleanResult result = clean(with_piece(7, 12.0), {.outliers = Unwanted::kKeep});
    EXPECT_EQ(result.report.num_floating, 7U);
}

TEST(Floaters, LargerAndNearerPiecesStay) {
    EXPECT_EQ(clean(with_piece(21, 12.0)).report.num_dropped(), 0U);  // 0.1 % of the sphere
    EXPECT_EQ(clean(with_piece(19, 3.0)).report.num_dropped(), 0U);
}

TEST(Floaters, TwoObjectsStay) {
    EXPECT_EQ(clean(with_piece(15'000, 50.0)).report.num_dropped(), 0U);
}

TEST(Clean, SameForAnyOrderAndThreads) {
    constexpr std::uint64_t n = 10'000;
    PointCloud cloud = shapes::sphere_cloud(n, 0.2 * sphere_spacing(n));
    add_scattered(cloud, n / 20, {-2, -1, -1}, {1, 1, 1});
    const CleanResult first = clean(cloud, {}, {.threads = 1});
    std::ranges::reverse(cloud.positions);
    std::ranges::reverse(cloud.normals);
    std::ranges::reverse(cloud.rows);
    const CleanResult second = clean(cloud, {}, {.threads = 4});
    ASSERT_EQ(first.cloud.dropped.size(), second.cloud.dropped.size());
    for (std::size_t i = 0; i < first.cloud.dropped.size(); ++i) {
        EXPECT_EQ(first.cloud.dropped[i].row, second.cloud.dropped[i].row);
        EXPECT_EQ(first.cloud.dropped[i].reason, second.cloud.dropped[i].reason);
    }
}

}  // namespace
}  // namespace pointbake
