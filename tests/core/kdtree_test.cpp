#include "core/kdtree.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/hash.h"

namespace pointbake {
namespace {

std::vector<Vec3d> random_points(std::size_t count, std::uint64_t seed, double offset) {
    std::vector<Vec3d> points(count);
    for (std::size_t i = 0; i < count; ++i)
        for (std::size_t k = 0; k < 3; ++k) points[i][k] = offset + random_unit(seed, 3 * i + k);
    return points;
}

/// A grid, every place taken twice: nothing but ties.
std::vector<Vec3d> doubled_grid(int side, double spacing) {
    std::vector<Vec3d> points;
    for (int copy = 0; copy < 2; ++copy)
        for (int z = 0; z < side; ++z)
            for (int y = 0; y < side; ++y)
                for (int x = 0; x < side; ++x)
                    points.push_back({spacing * x, spacing * y, spacing * z});
    return points;
}

std::vector<Neighbor> nearest_by_force(std::span<const Vec3d> points, Vec3d query, std::size_t k) {
    std::vector<Neighbor> all;
    for (Index i = 0; i < points.size(); ++i) {
        const Vec3d d = query - points[i];
        all.push_back({i, d.x * d.x + d.y * d.y + d.z * d.z});
    }
    std::sort(all.begin(), all.end(), [](const Neighbor& a, const Neighbor& b) {
        return std::pair(a.squared_distance, a.index) < std::pair(b.squared_distance, b.index);
    });
    all.resize(std::min(k, all.size()));
    return all;
}

void expect_same_as_by_force(std::span<const Vec3d> points, std::span<const Vec3d> queries,
                             std::size_t k) {
    const KdTree tree(points);
    std::vector<Neighbor> buffer(k);
    for (const Vec3d query : queries) {
        const auto found = tree.nearest(query, buffer);
        const auto expected = nearest_by_force(points, query, k);
        ASSERT_EQ(found.size(), expected.size());
        for (std::size_t i = 0; i < found.size(); ++i) {
            ASSERT_EQ(found[i].index, expected[i].index);
            ASSERT_EQ(found[i].squared_distance, expected[i].squared_distance);
        }
    }
}

TEST(KdTree, FindsWhatTryingAllPointsFinds) {
    const auto points = random_points(700, 1, 0.0);
    const auto queries = random_points(100, 2, 0.1);
    expect_same_as_by_force(points, queries, 1);
    expect_same_as_by_force(points, queries, 16);
    expect_same_as_by_force(points, queries, 64);
}

TEST(KdTree, OrdersTiesByIndex) {
    // A third is no binary fraction: lower bounds in the tree and distances round differently.
    for (const double spacing : {1.0, 1.0 / 3.0}) {
        const auto points = doubled_grid(5, spacing);
        expect_same_as_by_force(points, points, 1);
        expect_same_as_by_force(points, points, 2);
        expect_same_as_by_force(points, points, 17);
    }
}

TEST(KdTree, KeepsItsPrecisionFarFromTheOrigin) {
    const auto points = random_points(300, 3, 4.0e6);
    expect_same_as_by_force(points, points, 8);
}

TEST(KdTree, ReturnsAllPointsWhereThereAreFewerThanAsked) {
    const auto points = random_points(5, 4, 0.0);
    expect_same_as_by_force(points, points, 16);
    const std::vector<Vec3d> none;
    std::vector<Neighbor> buffer(4);
    EXPECT_TRUE(KdTree(none).nearest({}, buffer).empty());
    EXPECT_TRUE(KdTree(points).nearest({}, std::span(buffer).first(0)).empty());
}

TEST(KdTree, TakesPointsThatAreAllEqual) {
    const std::vector<Vec3d> points(500, Vec3d{1.0, 2.0, 3.0});
    const KdTree tree(points);
    std::vector<Neighbor> buffer(10);
    const auto found = tree.nearest({1.0, 2.0, 4.0}, buffer);
    ASSERT_EQ(found.size(), 10U);
    for (Index i = 0; i < 10; ++i) EXPECT_EQ(found[i].index, i);
}

}  // namespace
}  // namespace pointbake
