#include "reconstruct/thin.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/hash.h"
#include "support/shapes.h"

namespace pointbake {
namespace {

std::vector<Vec3d> random_points(std::size_t count) {
    std::vector<Vec3d> points;
    for (std::size_t i = 0; i < count; ++i)
        points.push_back({random_unit(1, 2 * i), random_unit(1, 2 * i + 1), 0.0});
    return points;
}

// By its definition: side of the square that each of the 12 nearest has.
double spacing_at(const std::vector<Vec3d>& points, Vec3d p) {
    std::vector<double> d2;
    for (const Vec3d q : points) d2.push_back(squared_length(q - p));
    std::nth_element(d2.begin(), d2.begin() + 12, d2.end());
    return std::sqrt(std::numbers::pi * d2[12] / 12.0);
}

TEST(Thin, KeepsNoTwoThatAreTooNearAndDropsNoMore) {
    constexpr double kShare = 0.7;
    const std::vector<Vec3d> points = random_points(2000);
    const std::vector<Index> kept = thin(points, {.nearest = kShare}, {});
    EXPECT_TRUE(std::is_sorted(kept.begin(), kept.end()));
    std::vector<double> spacing;
    for (const Vec3d p : points) spacing.push_back(spacing_at(points, p));
    const auto has_rival = [&](Index i) {
        return std::any_of(kept.begin(), kept.end(), [&](Index j) {
            return j != i && length(points[i] - points[j]) <
                                 kShare * std::min(spacing[i], spacing[j]) * (1.0 - 1e-9);
        });
    };
    std::vector<std::uint8_t> is_kept(points.size(), 0);
    for (Index i : kept) is_kept[i] = 1;
    for (Index i = 0; i < points.size(); ++i) ASSERT_EQ(has_rival(i), is_kept[i] == 0) << i;
}

TEST(Thin, KeepsOneOfEachPairOfNearDuplicates) {
    std::vector<Vec3d> points = shapes::sphere_cloud(1000).positions;
    for (std::size_t i = 0; i < 1000; ++i) points.push_back(points[i] * (1.0 + 1e-5));
    EXPECT_EQ(thin(points, {.nearest = 0.02}, {}).size(), 1000U);
}

TEST(Thin, FollowsTheDensity) {
    // A sixteenth of the density beyond x = 0.5: neither side is thinned more than the other.
    std::vector<Vec3d> points;
    for (const Vec3d p : random_points(20000))
        if (p.x < 0.5 || hash_of(p) % 16 == 0) points.push_back(p);
    const auto in_sparse = [&](Index i) { return points[i].x > 0.5; };
    std::vector<Index> all(points.size());
    std::iota(all.begin(), all.end(), Index{0});
    const std::vector<Index> kept = thin(points, {.nearest = 0.5}, {});
    const auto share = [&](const std::vector<Index>& of) {
        return static_cast<double>(std::count_if(of.begin(), of.end(), in_sparse)) /
               static_cast<double>(of.size());
    };
    EXPECT_NEAR(share(kept), share(all), 0.006);
    EXPECT_LT(kept.size(), points.size() * 8 / 10);
}

TEST(Thin, IsTheSameForAnyOrderAndNumberOfThreads) {
    std::vector<Vec3d> points = random_points(3000);
    const auto kept_places = [](const std::vector<Vec3d>& of, const Context& context) {
        std::vector<Vec3d> places;
        for (Index i : thin(of, {.nearest = 0.5}, context)) places.push_back(of[i]);
        std::sort(places.begin(), places.end(),
                  [](Vec3d a, Vec3d b) { return a.x != b.x ? a.x < b.x : a.y < b.y; });
        return places;
    };
    const std::vector<Vec3d> one = kept_places(points, {.threads = 1});
    EXPECT_EQ(kept_places(points, {.threads = 3}), one);
    std::reverse(points.begin(), points.end());
    EXPECT_EQ(kept_places(points, {}), one);
}

TEST(Thin, TakesAHandfulOfPoints) {
    EXPECT_EQ(thin(std::vector<Vec3d>{}, {.nearest = 0.5}, {}).size(), 0U);
    EXPECT_EQ(thin(std::vector<Vec3d>{{1, 2, 3}}, {.nearest = 0.5}, {}).size(), 1U);
    EXPECT_EQ(thin(std::vector<Vec3d>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {.nearest = 0.5}, {}).size(), 3U);
}

}  // namespace
}  // namespace pointbake
