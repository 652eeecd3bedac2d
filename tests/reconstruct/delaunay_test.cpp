#include "reconstruct/delaunay.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <thread>

#include "core/hash.h"
#include "pointbake/error.h"

namespace pointbake {
namespace {

std::vector<Vec3d> random_points(std::size_t n) {
    std::vector<Vec3d> points;
    for (std::size_t i = 0; i < n; ++i)
        points.push_back({random_unit(1, i), random_unit(2, i), random_unit(3, i)});
    return points;
}

double signed_volume(const std::vector<Vec3d>& p, const std::array<Index, 4>& c) {
    return dot(p[c[1]] - p[c[0]], cross(p[c[2]] - p[c[0]], p[c[3]] - p[c[0]]));
}

TEST(Delaunay, FillsTheCubeWithPositiveCells) {
    std::vector<Vec3d> points = random_points(500);
    for (int i = 0; i < 8; ++i)
        points.push_back({i & 1 ? 1. : 0., i & 2 ? 1. : 0., i & 4 ? 1. : 0.});
    double sum = 0.0;
    for (const auto& cell : delaunay(points).cells) {
        EXPECT_GT(signed_volume(points, cell), 0.0);
        sum += signed_volume(points, cell) / 6.0;
    }
    EXPECT_NEAR(sum, 1.0, 1e-12);
}

TEST(Delaunay, KeepsEveryOtherPointOutOfTheCircumspheres) {
    const std::vector<Vec3d> points = random_points(120);
    for (const auto& c : delaunay(points).cells) {
        const Vec3d o = points[c[0]];
        const Vec3d a = points[c[1]] - o, b = points[c[2]] - o, d = points[c[3]] - o;
        const Vec3d center = (cross(b, d) * squared_length(a) + cross(d, a) * squared_length(b) +
                              cross(a, b) * squared_length(d)) /
                             (2.0 * dot(a, cross(b, d)));
        for (const Vec3d& p : points)
            EXPECT_GE(length(p - o - center), length(center) * (1.0 - 1e-9));
    }
}

TEST(Delaunay, NeighborsShareTheOppositeFacet) {
    const std::vector<Vec3d> points = random_points(300);
    const Delaunay d = delaunay(points);
    for (Index c = 0; c < d.cells.size(); ++c) {
        for (std::size_t i = 0; i < 4; ++i) {
            const Index n = d.neighbors[c][i];
            if (n == kInvalidIndex) continue;
            for (std::size_t k = 0; k < 4; ++k) {
                const bool shared =
                    std::count(d.cells[n].begin(), d.cells[n].end(), d.cells[c][k]) == 1;
                EXPECT_EQ(shared, k != i);
            }
            EXPECT_EQ(std::count(d.neighbors[n].begin(), d.neighbors[n].end(), c), 1);
        }
    }
}

TEST(Delaunay, GivesCellsInOneOrderForAnyNumberOfThreads) {
    const std::vector<Vec3d> points = random_points(20000);
    const Delaunay one = delaunay(points, {.threads = 1}), seven = delaunay(points, {.threads = 7});
    EXPECT_EQ(one.cells, seven.cells);
    EXPECT_EQ(one.neighbors, seven.neighbors);
    EXPECT_TRUE(std::is_sorted(one.cells.begin(), one.cells.end()));
}

TEST(Delaunay, IsUniqueForCosphericalPoints) {
    std::vector<Vec3d> grid;
    for (int i = 0; i < 216; ++i) grid.push_back({i % 6 * 1.0, i / 6 % 6 * 1.0, i / 36 * 1.0});
    std::vector<Index> shuffled(grid.size());
    for (Index i = 0; i < shuffled.size(); ++i) shuffled[i] = i;
    std::sort(shuffled.begin(), shuffled.end(),
              [](Index a, Index b) { return hash64(a) < hash64(b); });
    EXPECT_EQ(delaunay(grid).cells, delaunay(grid, {}, shuffled).cells);
}

TEST(Delaunay, LeavesOutPointsInThePlaceOfOthers) {
    const std::vector<Vec3d> points = random_points(200);
    std::vector<Vec3d> twice = points;
    twice.insert(twice.end(), points.rbegin(), points.rend());
    twice.insert(twice.end(), 20, points.front());
    EXPECT_EQ(delaunay(twice).cells.size(), delaunay(points).cells.size());
}

TEST(Delaunay, TakesASubset) {
    const std::vector<Vec3d> points = random_points(100);
    std::vector<Index> odd;
    for (Index i = 1; i < 100; i += 2) odd.push_back(i);
    std::vector<Vec3d> chosen;
    for (Index i : odd) chosen.push_back(points[i]);
    Delaunay expected = delaunay(chosen);
    for (auto& cell : expected.cells)
        for (Index& v : cell) v = odd[v];
    const Delaunay d = delaunay(points, {}, odd);
    EXPECT_EQ(d.cells, expected.cells);
    EXPECT_EQ(d.neighbors, expected.neighbors);
}

TEST(Delaunay, GivesNoCellsWhereThereIsNoVolume) {
    EXPECT_TRUE(delaunay(random_points(3)).cells.empty());
    std::vector<Vec3d> flat = random_points(50);
    for (Vec3d& p : flat) p.z = 0.25;
    EXPECT_TRUE(delaunay(flat).cells.empty());
}

TEST(Delaunay, StopsWhenToldTo) {
    std::stop_source source;
    source.request_stop();
    try {
        delaunay(random_points(1000), {.stop = source.get_token()});
        FAIL() << "went on";
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::kCancelled);
    }
}

TEST(Delaunay, StopsWithinASecondInTheMiddle) {
    const std::vector<Vec3d> points = random_points(400000);
    std::stop_source source;
    std::jthread stopper([&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(300));
        source.request_stop();
    });
    EXPECT_THROW(delaunay(points, {.threads = 2, .stop = source.get_token()}), Error);
}

}  // namespace
}  // namespace pointbake
