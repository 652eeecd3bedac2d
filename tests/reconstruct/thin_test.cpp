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
    EXPECT_EQ(
        thin(std::vector<Vec3d>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {.nearest = 0.5}, {}).size(), 3U);
}

// Farthest of a point of the ball to the nearest of the kept ones, in spacings of all.
double coarsest(const std::vector<Vec3d>& points, const std::vector<Index>& kept, double spacing) {
    double most2 = 0.0;
    for (const Vec3d p : points) {
        double least2 = HUGE_VAL;
        for (Index k : kept) least2 = std::min(least2, squared_length(points[k] - p));
        most2 = std::max(most2, least2);
    }
    return std::sqrt(most2) / spacing;
}

TEST(ThinSmooth, KeepsASphereAsFineAsItBends) {
    // Discs of radius sqrt(2 t / k) with t = 0.02 spacings and k = 1.
    for (const std::uint64_t n : {5000U, 20000U}) {
        const std::vector<Vec3d> points = shapes::sphere_cloud(n).positions;
        const double spacing = std::sqrt(4.0 * std::numbers::pi / static_cast<double>(n));
        const std::vector<Index> kept = thin(points, {.tolerance = 0.02}, {});
        const double reach = std::max(1.0, std::sqrt(0.04 / spacing));
        if (reach == 1.0) {
            EXPECT_EQ(kept.size(), n);
        } else {
            EXPECT_LT(coarsest(points, kept, spacing), 1.05 * reach);
            EXPECT_LT(static_cast<double>(kept.size()), 0.9 * static_cast<double>(n));
        }
    }
}

TEST(ThinSmooth, KeepsFewOfAPlaneAndAllOfItsBorder) {
    constexpr int kSide = 200;
    const std::vector<Vec3d> points = shapes::plane_cloud(kSide, kSide, 1.0, 0.3).positions;
    const std::vector<Index> kept = thin(points, {.tolerance = 0.02}, {});
    EXPECT_LT(kept.size(), points.size() / 4);
    // Three rounds; points drawn two spacings apart at least are 2.4 spacings apart or so.
    EXPECT_GT(coarsest(points, kept, 1.0), 8.0);
    EXPECT_LT(coarsest(points, kept, 1.0), 20.0);
    std::vector<std::uint8_t> is_kept(points.size(), 0);
    for (Index i : kept) is_kept[i] = 1;
    Box box;
    for (const Vec3d p : points) box.extend(p);
    int num_lost = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Vec3d p = points[i];
        const double to_border = std::min(std::min(p.x - box.low.x, box.high.x - p.x),
                                          std::min(p.z - box.low.z, box.high.z - p.z));
        num_lost += to_border < 0.5 && is_kept[i] == 0 ? 1 : 0;
    }
    EXPECT_LE(num_lost, 2);  // of some 800
}

TEST(ThinSmooth, GrowsSlowlyAwayFromWhatStays) {
    // Next to the border a point's neighbours are no farther than it may be apart from them.
    const std::vector<Vec3d> points = shapes::plane_cloud(120, 120, 1.0, 0.3).positions;
    const std::vector<Index> kept = thin(points, {.tolerance = 0.02}, {});
    Box box;
    for (const Vec3d p : points) box.extend(p);
    for (const Vec3d p : points) {
        const double to_border = std::min(std::min(p.x - box.low.x, box.high.x - p.x),
                                          std::min(p.z - box.low.z, box.high.z - p.z));
        double least = HUGE_VAL;
        for (Index k : kept) least = std::min(least, length(points[k] - p));
        ASSERT_LT(least, 2.0 + 0.6 * to_border);
    }
}

TEST(ThinSmooth, KeepsCreases) {
    const std::vector<Vec3d> points = shapes::cube_cloud(40).positions;
    const std::vector<Index> kept = thin(points, {.tolerance = 0.02}, {});
    EXPECT_LT(kept.size(), points.size() * 2 / 3);
    std::vector<std::uint8_t> is_kept(points.size(), 0);
    for (Index i : kept) is_kept[i] = 1;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Vec3d p = points[i];
        int num_faces = 0;
        for (std::size_t k = 0; k < 3; ++k) num_faces += std::abs(p[k]) > 1.0 - 1e-9 ? 1 : 0;
        if (num_faces > 1) {
            ASSERT_EQ(is_kept[i], 1);
        }
    }
}

TEST(ThinSmooth, LeavesSheetsThatAreNear) {
    const auto share_kept = [](double gap) {
        std::vector<Vec3d> points = shapes::plane_cloud(60, 60, 1.0, 0.3).positions;
        const std::size_t n = points.size();
        for (std::size_t i = 0; i < n; ++i) points.push_back(points[i] + Vec3d{0.4, gap, 0.3});
        return static_cast<double>(thin(points, {.tolerance = 0.02}, {}).size()) /
               static_cast<double>(points.size());
    };
    EXPECT_GT(share_kept(3.5), 0.95);
    EXPECT_LT(share_kept(30.0), 0.4);
}

TEST(ThinSmooth, LeavesWhatIsRougherThanTheTolerance) {
    const auto share_kept = [](double noise) {
        std::vector<Vec3d> points = shapes::plane_cloud(60, 60, 1.0, 0.3).positions;
        for (std::size_t i = 0; i < points.size(); ++i)
            points[i].y += noise * shapes::random_normal(5, i);
        return static_cast<double>(thin(points, {.tolerance = 0.02}, {}).size()) /
               static_cast<double>(points.size());
    };
    EXPECT_LT(share_kept(0.003), 0.5);
    EXPECT_GT(share_kept(0.03), 0.98);
}

TEST(ThinSmooth, LosesNoMoreThanALength) {
    const std::vector<Vec3d> points = shapes::sphere_cloud(20000).positions;
    const auto kept = thin(points, {.tolerance = 0.02, .most_length = 1e-5}, {});
    EXPECT_EQ(kept.size(), points.size());
}

TEST(ThinSmooth, IsTheSameForAnyOrderAndNumberOfThreads) {
    std::vector<Vec3d> points = shapes::sphere_cloud(20000).positions;
    const auto kept_places = [](const std::vector<Vec3d>& of, const Context& context) {
        std::vector<Vec3d> places;
        for (Index i : thin(of, {.tolerance = 0.02}, context)) places.push_back(of[i]);
        std::sort(places.begin(), places.end(),
                  [](Vec3d a, Vec3d b) { return a.x != b.x ? a.x < b.x : a.y < b.y; });
        return places;
    };
    const std::vector<Vec3d> one = kept_places(points, {.threads = 1});
    EXPECT_LT(one.size(), points.size() * 9 / 10);
    EXPECT_EQ(kept_places(points, {.threads = 3}), one);
    std::reverse(points.begin(), points.end());
    EXPECT_EQ(kept_places(points, {}), one);
}

}  // namespace
}  // namespace pointbake
