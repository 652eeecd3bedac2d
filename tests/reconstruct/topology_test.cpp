// What Cocone and Tight Cocone make of hard samplings and shapes without noise: Euler number,
// borders and components.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <string>

#include "core/adjacency.h"
#include "core/hash.h"
#include "pointbake/denoise.h"
#include "pointbake/reconstruct.h"
#include "support/shapes.h"

namespace pointbake {
namespace {

using shapes::add_point;

constexpr double kPi = std::numbers::pi;

// Uniform random point of the unit sphere.
Vec3d random_direction(std::uint64_t seed, std::uint64_t i) {
    const double z = 2.0 * random_unit(seed, 2 * i) - 1.0;
    const double a = 2.0 * kPi * random_unit(seed, 2 * i + 1), r = std::sqrt(1.0 - z * z);
    return {r * std::cos(a), r * std::sin(a), z};
}

PointCloud random_sphere(std::uint64_t n, Vec3d center = {}, double radius = 1.0,
                         std::uint64_t seed = 1) {
    PointCloud cloud;
    for (std::uint64_t i = 0; i < n; ++i)
        add_point(cloud, center + random_direction(seed, i) * radius, {});
    return cloud;
}

void append(PointCloud& cloud, const PointCloud& more) {
    for (const Vec3d& p : more.positions) add_point(cloud, p, {});
}

Vec3d torus_point(double u, double v, double major = 1.0, double minor = 0.4) {
    const double r = major + minor * std::cos(v);
    return {r * std::cos(u), minor * std::sin(v), r * std::sin(u)};
}

PointCloud random_torus(std::uint64_t n) {
    PointCloud cloud;
    for (std::uint64_t i = 0; cloud.size() < n; ++i) {
        const double v = 2.0 * kPi * random_unit(22, i);
        if (1.4 * random_unit(23, i) < 1.0 + 0.4 * std::cos(v))
            add_point(cloud, torus_point(2.0 * kPi * random_unit(21, i), v), {});
    }
    return cloud;
}

// A jittered grid of nu x nv unit steps, placed by `at`, where `has` holds.
PointCloud jittered_sheet(int nu, int nv, std::uint64_t seed,
                          const std::function<Vec3d(double, double)>& at,
                          const std::function<bool(double, double)>& has = {}) {
    PointCloud cloud;
    for (int j = 0; j < nv; ++j) {
        for (int i = 0; i < nu; ++i) {
            const auto id = static_cast<std::uint64_t>(j * nu + i);
            const double u = i + 0.5 * random_unit(seed, 2 * id);
            const double v = j + 0.5 * random_unit(seed, 2 * id + 1);
            if (!has || has(u, v)) add_point(cloud, at(u, v), {});
        }
    }
    return cloud;
}

// Uniform random points where a signed distance is 0: those of a thin shell, moved onto it.
PointCloud implicit_cloud(std::uint64_t n, Vec3d half_extent,
                          const std::function<double(Vec3d)>& distance) {
    PointCloud cloud;
    const auto gradient = [&](Vec3d p) {
        constexpr double h = 1e-5;
        return Vec3d{distance(p + Vec3d{h, 0, 0}) - distance(p - Vec3d{h, 0, 0}),
                     distance(p + Vec3d{0, h, 0}) - distance(p - Vec3d{0, h, 0}),
                     distance(p + Vec3d{0, 0, h}) - distance(p - Vec3d{0, 0, h})} /
               (2.0 * h);
    };
    for (std::uint64_t i = 0; cloud.size() < n; ++i) {
        Vec3d p;
        for (std::size_t k = 0; k < 3; ++k)
            p[k] = half_extent[k] * (2.0 * random_unit(41 + k, i) - 1.0);
        if (std::fabs(distance(p)) > 0.02) continue;
        for (int step = 0; step < 5; ++step) {
            const Vec3d g = gradient(p);
            p -= g * (distance(p) / squared_length(g));
        }
        add_point(cloud, p, {});
    }
    return cloud;
}

// Two tori side by side, melted together.
double genus_two(Vec3d p) {
    const auto torus = [&](double x) {
        return std::hypot(std::hypot(p.x - x, p.z) - 1.0, p.y) - 0.35;
    };
    const double a = torus(-1.2), b = torus(1.2), h = std::max(0.3 - std::fabs(a - b), 0.0) / 0.3;
    return std::min(a, b) - h * h * 0.3 / 4.0;
}

struct Expected {
    std::int64_t euler;
    Index num_loops, num_components;
};

void expect_topology(const ReconstructResult& r, const Expected& expected) {
    const Topology t = topology(r.surface.mesh.positions.size(), r.surface.mesh.triangles);
    EXPECT_EQ(t.num_nonmanifold_edges + t.num_nonmanifold_vertices, 0U);
    EXPECT_EQ(t.euler(), expected.euler);
    EXPECT_EQ(t.num_boundary_loops, expected.num_loops);
    EXPECT_EQ(t.num_components, expected.num_components);
}

// Both the open surface, which must have closed by itself, and the watertight one.
void expect_closed_both_ways(const PointCloud& cloud, const Expected& expected) {
    for (const Surface surface : {Surface::kOpen, Surface::kWatertight}) {
        SCOPED_TRACE(to_word(surface));
        const ReconstructResult r = reconstruct(cloud, {.surface = surface});
        expect_topology(r, expected);
        EXPECT_GT(volume(r.surface.mesh.positions, r.surface.mesh.triangles), 0.0);
    }
}

double area_of(const ReconstructResult& r) {
    double area = 0.0;
    const auto& p = r.surface.mesh.positions;
    for (const Triangle& t : r.surface.mesh.triangles)
        area += 0.5 * length(cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]));
    return area;
}

TEST(Topology, OfARandomlySampledSphere) {
    expect_closed_both_ways(random_sphere(8000), {2, 0, 1});
}

TEST(Topology, OfARandomlySampledTorus) { expect_closed_both_ways(random_torus(10000), {0, 0, 1}); }

TEST(Topology, OfScanLinesFourTimesFartherApartThanTheirPoints) {
    PointCloud cloud;
    const int num_lines = 60;
    for (int line = 0; line < num_lines; ++line) {
        const double v = 2.0 * kPi * line / num_lines,
                     length = 2.0 * kPi * (1.0 + 0.4 * std::cos(v));
        const int n = static_cast<int>(length / (2.0 * kPi * 0.4 / num_lines / 4.0));
        for (int i = 0; i < n; ++i)
            add_point(cloud, torus_point(2.0 * kPi * (i + random_unit(5, line)) / n, v), {});
    }
    expect_closed_both_ways(cloud, {0, 0, 1});
}

TEST(Topology, OfASphereWithOneHalfSixteenTimesDenser) {
    PointCloud cloud;
    for (std::uint64_t i = 0; i < 20000; ++i) {
        const Vec3d d = random_direction(9, i);
        if (d.z > 0.0 || random_unit(10, i) < 1.0 / 16.0) add_point(cloud, d, {});
    }
    expect_closed_both_ways(cloud, {2, 0, 1});
}

TEST(Topology, OfTwoParallelSheets) {
    for (const int gap : {4, 3, 2, 1}) {
        PointCloud cloud;
        for (int side = 0; side < 2; ++side)
            append(cloud, jittered_sheet(
                              40, 40, 31 + static_cast<std::uint64_t>(side),
                              [&](double u, double v) { return Vec3d{u, v, double(gap * side)}; }));
        const ReconstructResult r = reconstruct(cloud, {.surface = Surface::kOpen});
        const std::string at = "_at_" + std::to_string(gap);
        RecordProperty("components" + at, static_cast<int>(r.report.num_components));
        RecordProperty("loops" + at, static_cast<int>(r.report.num_boundary_loops));
        if (gap == 4) expect_topology(r, {2, 2, 2});
    }
}

TEST(Topology, OfAHalfSphere) {
    PointCloud cloud;
    for (const Vec3d& p : random_sphere(8000).positions)
        if (p.y > 0.0) add_point(cloud, p, {});
    expect_topology(reconstruct(cloud, {.surface = Surface::kOpen}), {1, 1, 1});
    expect_topology(reconstruct(cloud, {.surface = Surface::kWatertight}), {2, 0, 1});
}

TEST(Topology, OfNestedSpheres) {
    PointCloud cloud = random_sphere(8000);
    append(cloud, random_sphere(2000, {}, 0.5, 2));
    expect_topology(reconstruct(cloud, {.surface = Surface::kOpen}), {4, 0, 2});
    const ReconstructResult r = reconstruct(cloud, {.surface = Surface::kWatertight});
    expect_topology(r, {4, 0, 2});
    const double exact = 4.0 / 3.0 * kPi * (1.0 - 0.125);  // the inner one is a cavity
    EXPECT_NEAR(volume(r.surface.mesh.positions, r.surface.mesh.triangles), exact, 0.02 * exact);
}

TEST(Topology, OfTwoTouchingSpheres) {
    PointCloud cloud = random_sphere(6000, {-1, 0, 0}, 1.0, 1);
    append(cloud, random_sphere(6000, {1, 0, 0}, 1.0, 2));
    for (const Surface surface : {Surface::kOpen, Surface::kWatertight}) {
        const ReconstructResult r = reconstruct(cloud, {.surface = surface});
        // They may be joined by a neck where they are closer than their points.
        const Index n = r.report.num_components;
        EXPECT_LE(n, 2U);
        expect_topology(r, {2 * std::int64_t{n}, 0, n});
    }
}

TEST(Topology, OfABodyOfGenusTwo) {
    expect_closed_both_ways(implicit_cloud(12000, {2.7, 0.5, 1.5}, genus_two), {-2, 0, 1});
}

TEST(Topology, OfASheetWithASquareHole) {
    const auto has = [](double u, double v) {
        return u < 20.0 || u > 40.0 || v < 20.0 || v > 40.0;
    };
    for (const double bend : {0.0, 1.0}) {
        const auto at = [&](double u, double v) {
            return Vec3d{u, v, bend * 3.0 * std::sin(0.1 * u)};
        };
        expect_topology(
            reconstruct(jittered_sheet(60, 60, 51, at, has), {.surface = Surface::kOpen}),
            {0, 2, 1});
    }
}

// Nearly all cells of such a grid are slivers, both sides of which were kept here and there.
void expect_whole_sheet(const PointCloud& cloud, double area) {
    const ReconstructResult r = reconstruct(cloud, {.surface = Surface::kOpen, .thin = Thin::kOff});
    EXPECT_LE(r.report.num_boundary_loops, 4U);
    EXPECT_LT(r.report.num_poor, cloud.size() / 5);
    EXPECT_NEAR(area_of(r), area, 0.02 * area);
}

TEST(Topology, OfASheetOfANearlyRegularGrid) {
    expect_whole_sheet(shapes::plane_cloud(150, 150, 1.0, 0.03, 0.02), 149.0 * 149.0);
}

TEST(Topology, OfASheetOfARegularGridThatWasNoisy) {
    const DenoiseResult result = denoise(shapes::plane_cloud(150, 150, 1.0, 0.0, 0.35));
    ASSERT_FALSE(result.cloud.measured.empty());
    expect_whole_sheet(result.cloud, 149.0 * 149.0);
}

TEST(Topology, OfThreeSheetsOnOneEdge) {
    PointCloud cloud;
    constexpr int kLength = 50, kWidth = 30;
    for (std::uint64_t sheet = 0; sheet < 3; ++sheet) {
        const double a = 2.0 * kPi / 3.0 * static_cast<double>(sheet);
        append(cloud, jittered_sheet(kLength, kWidth, 61 + sheet, [&](double u, double v) {
                   return Vec3d{u, (v + 0.25) * std::cos(a), (v + 0.25) * std::sin(a)};
               }));
    }
    const ReconstructResult r = reconstruct(cloud, {.surface = Surface::kOpen});
    const Topology t = topology(r.surface.mesh.positions.size(), r.surface.mesh.triangles);
    EXPECT_EQ(t.num_nonmanifold_edges + t.num_nonmanifold_vertices, 0U);
    EXPECT_NEAR(area_of(r), 3.0 * (kLength - 0.75) * (kWidth - 0.75), 0.03 * 3 * kLength * kWidth);
    EXPECT_LT(r.report.num_unused - r.report.num_thinned, cloud.size() / 200);
}

}  // namespace
}  // namespace pointbake
