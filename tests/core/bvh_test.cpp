#include "core/bvh.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/hash.h"

namespace pointbake {
namespace {

double uniform(std::uint64_t seed, std::uint64_t i) { return 2.0 * random_unit(seed, i) - 1.0; }

Vec3d random_point(std::uint64_t seed, std::uint64_t i) {
    return {uniform(seed, 3 * i), uniform(seed, 3 * i + 1), uniform(seed, 3 * i + 2)};
}

struct Soup {
    std::vector<Vec3d> positions;
    std::vector<Triangle> triangles;
};

// Loose triangles of size about `size` in a cube of side 2 around `center`.
Soup random_soup(Index n, double size, Vec3d center, std::uint64_t seed) {
    Soup soup;
    for (Index t = 0; t < n; ++t) {
        const Vec3d c = center + random_point(seed, t);
        for (Index k = 0; k < 3; ++k)
            soup.positions.push_back(c + random_point(seed + 1, 3 * t + k) * size);
        soup.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
    }
    return soup;
}

// Squared distance by dense search over barycentrics: slow, and independent of the tested code.
double searched_distance(Vec3d p, Vec3d a, Vec3d b, Vec3d c) {
    constexpr int kSteps = 200;
    double best = HUGE_VAL;
    for (int i = 0; i <= kSteps; ++i) {
        for (int j = 0; i + j <= kSteps; ++j) {
            const double u = i / double{kSteps}, v = j / double{kSteps};
            best = std::min(best, length(p - (a * (1.0 - u - v) + b * u + c * v)));
        }
    }
    return best;
}

ClosestPoint closest_by_force(const Soup& soup, Vec3d p) {
    ClosestPoint best;
    best.squared_distance = HUGE_VAL;
    for (Index t = 0; t < soup.triangles.size(); ++t) {
        const Triangle& v = soup.triangles[t];
        ClosestPoint c = closest_point_on_triangle(p, soup.positions[v[0]], soup.positions[v[1]],
                                                   soup.positions[v[2]]);
        c.triangle = t;
        if (c.squared_distance < best.squared_distance) best = c;
    }
    return best;
}

TEST(Bvh, ClosestPointOnTriangleAgreesWithASearchOverTheTriangle) {
    for (std::uint64_t i = 0; i < 60; ++i) {
        const Vec3d p = random_point(1, i), a = random_point(2, i), b = random_point(3, i),
                    c = random_point(4, i);
        const ClosestPoint found = closest_point_on_triangle(p, a, b, c);
        const double searched = searched_distance(p, a, b, c);
        EXPECT_LE(std::sqrt(found.squared_distance), searched + 1e-12);
        EXPECT_GE(std::sqrt(found.squared_distance), searched - 0.02);
        const Vec3d bary = found.barycentric;
        EXPECT_NEAR(bary.x + bary.y + bary.z, 1.0, 1e-14);
        EXPECT_GE(std::min({bary.x, bary.y, bary.z}), 0.0);
        EXPECT_LT(length(a * bary.x + b * bary.y + c * bary.z - found.point), 1e-14);
    }
}

TEST(Bvh, ClosestPointOfEachRegionIsExact) {
    const Vec3d a{0, 0, 0}, b{1, 0, 0}, c{0, 1, 0};
    const auto at = [&](Vec3d p) { return closest_point_on_triangle(p, a, b, c).point; };
    EXPECT_EQ(at({-1, -1, 2}), a);
    EXPECT_EQ(at({3, -1, 2}), b);
    EXPECT_EQ(at({-1, 3, 2}), c);
    EXPECT_EQ(at({0.5, -1, 2}), (Vec3d{0.5, 0, 0}));
    EXPECT_EQ(at({-1, 0.25, 2}), (Vec3d{0, 0.25, 0}));
    EXPECT_EQ(at({1, 1, 2}), (Vec3d{0.5, 0.5, 0}));
    EXPECT_EQ(at({0.25, 0.25, 2}), (Vec3d{0.25, 0.25, 0}));
}

TEST(Bvh, ClosestPointOnFlatTrianglesIsFinite) {
    const Vec3d a{0, 0, 0}, b{2, 0, 0}, p{1, 1, 0};
    EXPECT_DOUBLE_EQ(closest_point_on_triangle(p, a, b, a).squared_distance, 1.0);
    EXPECT_DOUBLE_EQ(closest_point_on_triangle(p, a, a, b).squared_distance, 1.0);
    EXPECT_DOUBLE_EQ(closest_point_on_triangle(p, b, a, a).squared_distance, 1.0);
    EXPECT_DOUBLE_EQ(closest_point_on_triangle(p, a, a, a).squared_distance, 2.0);
    EXPECT_DOUBLE_EQ(closest_point_on_triangle(p, a, b, b * 0.25).squared_distance, 1.0);
}

TEST(Bvh, ClosestTriangleIsTheOneThatBruteForceFinds) {
    const Soup soup = random_soup(600, 0.2, {}, 5);
    const TriangleBvh bvh(soup.positions, soup.triangles);
    for (std::uint64_t i = 0; i < 300; ++i) {
        const Vec3d p = random_point(9, i) * 1.5;
        const ClosestPoint expected = closest_by_force(soup, p);
        const auto found = bvh.closest(p);
        ASSERT_TRUE(found);
        EXPECT_EQ(found->triangle, expected.triangle);
        EXPECT_EQ(found->squared_distance, expected.squared_distance);
    }
}

TEST(Bvh, KeepsPrecisionFarFromTheOrigin) {
    const Soup soup = random_soup(300, 0.05, {6.5e5, 4.5e6, 100.0}, 6);
    const TriangleBvh bvh(soup.positions, soup.triangles);
    for (std::uint64_t i = 0; i < 100; ++i) {
        const Vec3d p = soup.positions[i] + random_point(10, i) * 0.01;
        EXPECT_EQ(bvh.closest(p)->triangle, closest_by_force(soup, p).triangle);
    }
}

TEST(Bvh, FindsNothingBeyondTheGivenDistanceAndTheBorderCounts) {
    const std::vector<Vec3d> positions{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    const std::vector<Triangle> triangles{{0, 1, 2}};
    const TriangleBvh bvh(positions, triangles);
    EXPECT_FALSE(bvh.closest({0.2, 0.2, 2.0}, 1.999));
    EXPECT_TRUE(bvh.closest({0.2, 0.2, 2.0}, 2.0));
}

TEST(Bvh, TiesGoToTheLowerIndex) {
    std::vector<Vec3d> positions{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    const std::vector<Triangle> triangles(40, Triangle{0, 1, 2});
    const TriangleBvh bvh(positions, triangles);
    EXPECT_EQ(bvh.closest({0.2, 0.2, 1.0})->triangle, 0U);
    EXPECT_EQ(bvh.first_hit({0.2, 0.2, 1.0}, {0, 0, -1})->triangle, 0U);
}

TEST(Bvh, RaysHitTheFirstTriangleThatBruteForceFinds) {
    const Soup soup = random_soup(400, 0.3, {}, 7);
    const TriangleBvh bvh(soup.positions, soup.triangles);
    int hits = 0;
    for (std::uint64_t i = 0; i < 300; ++i) {
        const Vec3d o = random_point(11, i) * 2.0, d = random_point(12, i);
        double best = HUGE_VAL;
        for (const Triangle& t : soup.triangles) {
            const Vec3d a = soup.positions[t[0]], b = soup.positions[t[1]],
                        c = soup.positions[t[2]];
            const Vec3d n = cross(b - a, c - a);
            const double s = dot(a - o, n) / dot(d, n);
            const Vec3d q = o + d * s;
            const bool inside = dot(cross(b - a, q - a), n) > 0 &&
                                dot(cross(c - b, q - b), n) > 0 && dot(cross(a - c, q - c), n) > 0;
            if (inside && s > 0.0) best = std::min(best, s);
        }
        const auto hit = bvh.first_hit(o, d);
        ASSERT_EQ(hit.has_value(), best < HUGE_VAL);
        if (!hit) continue;
        ++hits;
        EXPECT_NEAR(hit->t, best, 1e-9 * (1.0 + best));
    }
    EXPECT_GT(hits, 50);
}

TEST(Bvh, RaysDoNotSlipThroughSharedEdges) {
    // A fan around the origin: rays at its edges and its centre all hit.
    std::vector<Vec3d> positions{{0, 0, 0}};
    const double xs[] = {1, 0.7, 0, -0.7, -1, -0.7, 0, 0.7},
                 ys[] = {0, 0.7, 1, 0.7, 0, -0.7, -1, -0.7};
    std::vector<Triangle> triangles;
    for (Index k = 0; k < 8; ++k) {
        positions.push_back({xs[k], ys[k], 0.1 * static_cast<double>(k % 2)});
        triangles.push_back({0, k + 1, (k + 1) % 8 + 1});
    }
    const TriangleBvh bvh(positions, triangles);
    for (Index k = 0; k < 8; ++k) {
        for (double s : {0.0, 0.1, 1.0 / 3.0, 0.77}) {
            const Vec3d target = positions[k + 1] * s, o{0.3, -0.2, 5.0};
            EXPECT_TRUE(bvh.first_hit(o, target - o)) << k << " " << s;
        }
    }
    EXPECT_FALSE(bvh.first_hit({0, 0, 1}, {0, 0, 1}));
    EXPECT_FALSE(bvh.first_hit({0, 0, 1}, {0, 0, -1}, 0.5));
}

TEST(Bvh, EqualAndFlatTrianglesAreNoTrouble) {
    std::vector<Vec3d> positions(3, Vec3d{1, 2, 3});
    const std::vector<Triangle> triangles(1000, Triangle{0, 1, 2});
    const TriangleBvh bvh(positions, triangles);
    EXPECT_DOUBLE_EQ(bvh.closest({1, 2, 5})->squared_distance, 4.0);
    EXPECT_FALSE(bvh.first_hit({1, 2, 5}, {0, 0, -1}));
    const TriangleBvh empty({}, {});
    EXPECT_FALSE(empty.closest({0, 0, 0}));
    EXPECT_FALSE(empty.first_hit({0, 0, 0}, {1, 0, 0}));
}

}  // namespace
}  // namespace pointbake
