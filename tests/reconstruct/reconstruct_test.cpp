#include "pointbake/reconstruct.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>

#include "core/adjacency.h"
#include "core/bvh.h"
#include "core/hash.h"
#include "pointbake/error.h"
#include "support/shapes.h"

namespace pointbake {
namespace {

using shapes::add_point;

PointCloud cloud_of(std::vector<Vec3d> points) {
    PointCloud cloud;
    for (const Vec3d& p : points) add_point(cloud, p, {});
    return cloud;
}

PointCloud random_cube(std::uint64_t n) {
    PointCloud cloud;
    for (std::uint64_t i = 0; i < n; ++i) {
        const std::size_t axis = hash64(5, i) % 3;
        Vec3d p, normal;
        p[axis] = normal[axis] = hash64(6, i) % 2 == 0 ? -1.0 : 1.0;
        p[(axis + 1) % 3] = 2.0 * random_unit(7, i) - 1.0;
        p[(axis + 2) % 3] = 2.0 * random_unit(8, i) - 1.0;
        add_point(cloud, p, normal);
    }
    return cloud;
}

PointCloud random_sphere(std::uint64_t n) {
    PointCloud cloud;
    for (std::uint64_t i = 0; i < n; ++i) {
        const double z = 2.0 * random_unit(3, i) - 1.0,
                     a = 2.0 * std::numbers::pi * random_unit(4, i);
        const double r = std::sqrt(1.0 - z * z);
        const Vec3d p{r * std::cos(a), r * std::sin(a), z};
        add_point(cloud, p, p);
    }
    return cloud;
}

PointCloud permuted(const PointCloud& cloud) {
    std::vector<std::size_t> order(cloud.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(), [](auto a, auto b) { return hash64(a) < hash64(b); });
    PointCloud result;
    for (std::size_t i : order) add_point(result, cloud.positions[i], {});
    return result;
}

// The triangles by coordinates, in an order of their own.
std::vector<std::array<std::array<double, 3>, 3>> triangle_set(const DenseMesh& dense) {
    std::vector<std::array<std::array<double, 3>, 3>> set;
    for (const Triangle& t : dense.mesh.triangles) {
        auto& corners = set.emplace_back();
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3d p = dense.mesh.positions[t[k]];
            corners[k] = {p.x, p.y, p.z};
        }
        std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()),
                    corners.end());
    }
    std::sort(set.begin(), set.end());
    return set;
}

Topology topology_of(const ReconstructResult& r) {
    return topology(r.surface.mesh.positions.size(), r.surface.mesh.triangles);
}

void expect_closed(const ReconstructResult& r) {
    EXPECT_EQ(r.report.surface, Surface::kWatertight) << r.report.reason;
    const Topology t = topology_of(r);
    EXPECT_TRUE(t.is_closed_manifold())
        << t.num_boundary_edges << " border edges, " << t.num_nonmanifold_edges
        << " pinched edges, " << t.num_nonmanifold_vertices << " pinched vertices";
    EXPECT_EQ(t.num_vertices, r.surface.mesh.positions.size());
    EXPECT_GT(volume(r.surface.mesh.positions, r.surface.mesh.triangles), 0.0);
}

ErrorCode error_of(const PointCloud& cloud, const ReconstructOptions& options = {}) {
    try {
        reconstruct(cloud, options);
    } catch (const Error& error) {
        return error.code();
    }
    ADD_FAILURE() << "no error";
    return ErrorCode::kEmpty;
}

TEST(Reconstruct, FindsTheWholeSphere) {
    for (const std::uint64_t n : {500U, 2000U}) {
        const ReconstructResult r = reconstruct(shapes::sphere_cloud(n));
        expect_closed(r);
        EXPECT_EQ(topology_of(r).euler(), 2);
        EXPECT_EQ(r.surface.mesh.triangles.size(), 2 * n - 4);
        EXPECT_EQ(r.report.num_unused, 0U);
        EXPECT_EQ(r.report.num_poor, 0U);
    }
}

TEST(Reconstruct, StaysNearTheSphereEverywhere) {
    const std::uint64_t n = 2000;
    const ReconstructResult r = reconstruct(shapes::sphere_cloud(n));
    const double spacing2 = 4.0 * std::numbers::pi / static_cast<double>(n);
    for (const Triangle& t : r.surface.mesh.triangles) {
        const auto& p = r.surface.mesh.positions;
        EXPECT_GE(length((p[t[0]] + p[t[1]] + p[t[2]]) / 3.0), 1.0 - spacing2 / 2.0);
    }
}

TEST(Reconstruct, KeepsTheHoleOfATorus) {
    const ReconstructResult r = reconstruct(shapes::torus_cloud(5000));
    expect_closed(r);
    EXPECT_EQ(topology_of(r).euler(), 0);
    const double exact = 2.0 * std::numbers::pi * std::numbers::pi * 0.4 * 0.4;
    EXPECT_NEAR(volume(r.surface.mesh.positions, r.surface.mesh.triangles), exact, 0.01 * exact);
}

TEST(Reconstruct, LeavesAHalfSphereOpen) {
    const ReconstructResult r = reconstruct(shapes::half_sphere_cloud(2000));
    EXPECT_EQ(r.report.surface, Surface::kOpen) << r.report.reason;
    const Topology t = topology_of(r);
    EXPECT_EQ(t.num_boundary_loops, 1U);
    EXPECT_EQ(t.num_components, 1U);
    EXPECT_EQ(t.num_nonmanifold_edges + t.num_nonmanifold_vertices, 0U);
    EXPECT_EQ(t.euler(), 1);
    EXPECT_EQ(r.report.num_unused, 0U);
}

TEST(Reconstruct, TurnsOpenSurfacesOutwards) {
    const ReconstructResult r = reconstruct(shapes::half_sphere_cloud(2000));
    const auto& p = r.surface.mesh.positions;
    for (const Triangle& t : r.surface.mesh.triangles)
        EXPECT_GT(dot(cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]), p[t[0]]), 0.0);
}

TEST(Reconstruct, CapsAHalfSphereIfAsked) {
    const ReconstructResult r =
        reconstruct(shapes::half_sphere_cloud(2000), {.surface = Surface::kWatertight});
    expect_closed(r);
    EXPECT_EQ(topology_of(r).euler(), 2);
    const double exact = 2.0 / 3.0 * std::numbers::pi;
    EXPECT_NEAR(volume(r.surface.mesh.positions, r.surface.mesh.triangles), exact, 0.02 * exact);
    EXPECT_NEAR(r.report.added_area_fraction, 1.0 / 3.0, 0.02);
}

TEST(Reconstruct, ClosesSharpCubes) {
    for (const PointCloud& cloud : {shapes::cube_cloud(40), random_cube(10000)}) {
        const ReconstructResult r = reconstruct(cloud);
        expect_closed(r);
        EXPECT_NEAR(volume(r.surface.mesh.positions, r.surface.mesh.triangles), 8.0, 0.08);
        EXPECT_LT(r.report.num_unused - r.report.num_thinned, cloud.size() / 200);
    }
}

TEST(Reconstruct, ClosesARandomlySampledSphere) {
    const ReconstructResult r = reconstruct(random_sphere(10000));
    expect_closed(r);
    EXPECT_EQ(topology_of(r).euler(), 2);
    EXPECT_LT(r.report.num_unused - r.report.num_thinned, 20U);
}

TEST(Reconstruct, KeepsTwoSpheresApart) {
    PointCloud cloud = shapes::sphere_cloud(3000);
    for (const Vec3d& p : shapes::sphere_cloud(3000, 0.0, 0.5, {1.6, 0.0, 0.0}).positions)
        add_point(cloud, p, {});
    const ReconstructResult r = reconstruct(cloud);
    expect_closed(r);
    EXPECT_EQ(r.report.num_components, 2U);
    EXPECT_EQ(topology_of(r).euler(), 4);
}

TEST(Reconstruct, KeepsANestedSphereAsACavity) {
    PointCloud cloud = shapes::sphere_cloud(4000);
    for (const Vec3d& p : shapes::sphere_cloud(1000, 0.0, 0.5).positions) add_point(cloud, p, {});
    const ReconstructResult r = reconstruct(cloud);
    expect_closed(r);
    const double exact = 4.0 / 3.0 * std::numbers::pi * (1.0 - 0.125);
    EXPECT_NEAR(volume(r.surface.mesh.positions, r.surface.mesh.triangles), exact, 0.02 * exact);
}

TEST(Reconstruct, HoldsThinPlatesTogether) {
    // 3 spacings thick.
    PointCloud cloud = shapes::cube_cloud(40);
    for (Vec3d& p : cloud.positions) p.y *= 0.075;
    PointCloud thin;
    for (std::size_t i = 0; i < cloud.size(); ++i)
        if (std::abs(cloud.normals[i].y) > 0.5F || i % 8 == 0)
            add_point(thin, cloud.positions[i], {});
    const ReconstructResult r = reconstruct(thin, {.surface = Surface::kWatertight});
    expect_closed(r);
    EXPECT_NEAR(volume(r.surface.mesh.positions, r.surface.mesh.triangles), 0.6, 0.03);
}

// Two parallel sheets of jittered points, `gap` spacings apart: a sheet of cloth, say.
PointCloud cloth(int n, double gap) {
    PointCloud cloud;
    for (std::uint64_t side = 0; side < 2; ++side) {
        for (int j = 0; j < n; ++j) {
            for (int i = 0; i < n; ++i) {
                const auto id = static_cast<std::uint64_t>((j * n + i) * 2) + side;
                add_point(cloud,
                          {i + 0.7 * random_unit(11, id), j + 0.7 * random_unit(12, id),
                           gap * static_cast<double>(side)},
                          {});
            }
        }
    }
    return cloud;
}

TEST(Reconstruct, CoversBothSidesOfAThinCloth) {
    constexpr int kSide = 60;
    for (double gap : {0.6, 0.9, 1.2, 1.6}) {
        const ReconstructResult r = reconstruct(cloth(kSide, gap), {.surface = Surface::kOpen});
        const auto& p = r.surface.mesh.positions;
        double up = 0.0, down = 0.0;
        for (const Triangle& v : r.surface.mesh.triangles) {
            const double z = 0.5 * cross(p[v[1]] - p[v[0]], p[v[2]] - p[v[0]]).z;
            (z > 0.0 ? up : down) += std::fabs(z);
        }
        const double area = (kSide - 0.65) * (kSide - 0.65);
        EXPECT_NEAR(up, area, 0.01 * area) << gap;
        EXPECT_NEAR(down, area, 0.01 * area) << gap;
        const Topology t = topology_of(r);
        EXPECT_EQ(t.num_components, 1U) << gap;
        EXPECT_EQ(t.num_boundary_loops, 0U) << gap;
        EXPECT_EQ(t.num_nonmanifold_edges + t.num_nonmanifold_vertices, 0U) << gap;
        EXPECT_GE(t.euler(), 2 - 2 * 4) << gap;  // few of the many gaps become handles
    }
}

TEST(Reconstruct, ClosesNoisySpheresWhateverTheyLookLike) {
    const double spacing = std::sqrt(4.0 * std::numbers::pi / 3000.0);
    for (const double noise : {0.05, 0.1, 0.2, 0.3}) {
        const ReconstructResult r = reconstruct(shapes::sphere_cloud(3000, noise * spacing),
                                                {.surface = Surface::kWatertight});
        expect_closed(r);
        const double v = volume(r.surface.mesh.positions, r.surface.mesh.triangles);
        const int percent = static_cast<int>(100 * noise + 0.5);
        RecordProperty("poor_at_" + std::to_string(percent), static_cast<int>(r.report.num_poor));
        RecordProperty("volume_ppm_at_" + std::to_string(percent),
                       static_cast<int>(1e6 * v * 0.75 / std::numbers::pi));
        if (noise <= 0.1) {
            EXPECT_NEAR(v * 0.75 / std::numbers::pi, 1.0, 0.02);
        }
    }
}

TEST(Reconstruct, TakesApartWhatTouchesInAPoint) {
    // Two cubes that share one corner point.
    PointCloud cloud;
    for (int i = 0; i <= 10; ++i)
        for (int j = 0; j <= 10; ++j)
            for (int k = 0; k <= 10; ++k) {
                if (i % 10 != 0 && j % 10 != 0 && k % 10 != 0) continue;
                add_point(cloud, {i * 0.1, j * 0.1, k * 0.1}, {});
                if (i + j + k > 0) add_point(cloud, {-i * 0.1, -j * 0.1, -k * 0.1}, {});
            }
    expect_closed(reconstruct(cloud, {.surface = Surface::kWatertight}));
}

TEST(Reconstruct, MakesFlatCloudsFlatMeshes) {
    for (const double jitter : {0.0, 0.3}) {
        PointCloud cloud = shapes::plane_cloud(30, 20, 0.1, jitter);
        const ReconstructResult r = reconstruct(cloud);
        EXPECT_EQ(r.report.surface, Surface::kOpen);
        const Topology t = topology_of(r);
        EXPECT_EQ(t.num_boundary_loops, 1U);
        EXPECT_EQ(t.euler(), 1);
        double area = 0.0;
        const auto& p = r.surface.mesh.positions;
        for (const Triangle& f : r.surface.mesh.triangles)
            area += 0.5 * length(cross(p[f[1]] - p[f[0]], p[f[2]] - p[f[0]]));
        EXPECT_NEAR(area, 2.9 * 1.9, 0.05 * 2.9 * 1.9);
        EXPECT_LE(r.report.num_unused - r.report.num_thinned, 4U);
    }
}

TEST(Reconstruct, LeavesTheRimsOfNarrowSheetsOpen) {
    for (const int width : {3, 5, 7, 10}) {
        const Topology t =
            topology_of(reconstruct(shapes::plane_cloud(13, width), {.thin = Thin::kOff}));
        EXPECT_EQ(t.num_boundary_loops, 1U) << width;
        EXPECT_EQ(t.num_triangles, 2U * 12U * static_cast<Index>(width - 1)) << width;
    }
}

TEST(Reconstruct, TakesTiltedPlanesAndTinyOnesForFlat) {
    PointCloud cloud = shapes::plane_cloud(30, 20, 0.1, 0.3);
    for (Vec3d& p : cloud.positions)
        p = Vec3d{5e5, 4e6, 100.0} + Vec3d{0.6 * p.x - 0.8 * p.z, 0.3 * p.x, 0.8 * p.x + 0.6 * p.z};
    EXPECT_EQ(reconstruct(cloud).report.num_boundary_loops, 1U);
    EXPECT_GT(
        reconstruct(cloud_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}})).surface.mesh.triangles.size(), 0U);
}

TEST(Reconstruct, RefusesWhatSpansNoSurface) {
    EXPECT_EQ(error_of({}), ErrorCode::kDegenerate);
    EXPECT_EQ(error_of(cloud_of({{1, 2, 3}})), ErrorCode::kDegenerate);
    EXPECT_EQ(error_of(cloud_of({{1, 2, 3}, {2, 3, 4}})), ErrorCode::kDegenerate);
    EXPECT_EQ(error_of(cloud_of(std::vector<Vec3d>(1000, {1, 2, 3}))), ErrorCode::kDegenerate);
    std::vector<Vec3d> line;
    for (int i = 0; i < 100; ++i) line.push_back({0.1 * i, 0.2 * i, -0.3 * i});
    EXPECT_EQ(error_of(cloud_of(line)), ErrorCode::kDegenerate);
    EXPECT_EQ(error_of(cloud_of({{0, 0, 0}, {1, 0, 0}, {0, std::nan(""), 1}})),
              ErrorCode::kInvalidInput);
    EXPECT_EQ(error_of(shapes::plane_cloud(10, 10), {.surface = Surface::kWatertight}),
              ErrorCode::kDegenerate);
}

TEST(Reconstruct, RefusesContradictingOptions) {
    const PointCloud cloud = shapes::sphere_cloud(100);
    EXPECT_EQ(error_of(cloud, {.surface = Surface::kGiven}), ErrorCode::kInvalidOption);
    EXPECT_EQ(error_of(cloud, {.surface = Surface::kOpen, .method = Method::kTightCocone}),
              ErrorCode::kInvalidOption);
    EXPECT_EQ(error_of(cloud, {.surface = Surface::kWatertight, .method = Method::kCocone}),
              ErrorCode::kInvalidOption);
}

TEST(Reconstruct, SurvivesFourPoints) {
    const PointCloud cloud = cloud_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
    try {
        EXPECT_GT(reconstruct(cloud).surface.mesh.triangles.size(), 0U);
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::kDegenerate);
    }
}

TEST(Reconstruct, IgnoresDuplicates) {
    PointCloud cloud = shapes::sphere_cloud(1000);
    const auto expected = triangle_set(reconstruct(cloud).surface);
    for (int k = 0; k < 500; ++k) add_point(cloud, cloud.positions[17], {});
    const ReconstructResult r = reconstruct(cloud);
    EXPECT_EQ(triangle_set(r.surface), expected);
    EXPECT_EQ(r.report.num_unused, 500U);
}

TEST(Reconstruct, DoesNotDependOnTheOrderOfPoints) {
    for (const Surface surface : {Surface::kOpen, Surface::kWatertight}) {
        const PointCloud cloud = random_cube(3000);
        const ReconstructOptions options{.surface = surface};
        EXPECT_EQ(triangle_set(reconstruct(cloud, options).surface),
                  triangle_set(reconstruct(permuted(cloud), options).surface));
    }
}

TEST(Reconstruct, DoesNotDependOnThreads) {
    for (const Surface surface : {Surface::kOpen, Surface::kWatertight}) {
        const PointCloud cloud = random_cube(5000);
        const ReconstructOptions options{.surface = surface};
        const ReconstructResult one = reconstruct(cloud, options, {.threads = 1});
        const ReconstructResult seven = reconstruct(cloud, options, {.threads = 7});
        EXPECT_EQ(one.surface.mesh.triangles, seven.surface.mesh.triangles);
        EXPECT_EQ(one.surface.vertex_points, seven.surface.vertex_points);
        EXPECT_EQ(one.report.reason, seven.report.reason);
    }
}

TEST(Reconstruct, KeepsItsTopologyWhenMovedAndScaled) {
    const PointCloud cloud = random_cube(4000);
    const ReconstructResult r = reconstruct(cloud);
    for (const double scale : {1e-6, 1e6}) {
        PointCloud moved = cloud;
        for (Vec3d& p : moved.positions) p = p * scale + Vec3d{3.0, -5.0, 7.0} * scale;
        const Topology a = topology_of(r), b = topology_of(reconstruct(moved));
        EXPECT_EQ(a.euler(), b.euler());
        EXPECT_NEAR(a.num_triangles, b.num_triangles, 0.01 * a.num_triangles);
    }
}

TEST(Reconstruct, NamesThePointUnderEachVertex) {
    const PointCloud cloud = permuted(random_cube(3000));
    const ReconstructResult r = reconstruct(cloud);
    ASSERT_EQ(r.surface.vertex_points.size(), r.surface.mesh.positions.size());
    for (std::size_t v = 0; v < r.surface.vertex_points.size(); ++v)
        EXPECT_EQ(cloud.positions[r.surface.vertex_points[v]], r.surface.mesh.positions[v]);
    EXPECT_TRUE(std::is_sorted(r.surface.vertex_points.begin(), r.surface.vertex_points.end()));
    EXPECT_EQ(r.report.num_triangles, r.surface.mesh.triangles.size());
}

TEST(Reconstruct, SaysWhyItChose) {
    const ReconstructResult r = reconstruct(shapes::half_sphere_cloud(2000));
    EXPECT_THAT(r.report.reason,
                testing::MatchesRegex("closing would add 3.* % of the area .limit 15 %. "
                                      "and lose .* .limit 5 %.; .* of 2000 points are poor"));
    EXPECT_EQ(r.report.method, Method::kCocone);
    EXPECT_THAT(reconstruct(shapes::sphere_cloud(2000)).report.reason,
                testing::StartsWith("closing adds only 0.0 % of the area (limit 15 %)"));
    EXPECT_THAT(
        reconstruct(shapes::sphere_cloud(2000), {.surface = Surface::kWatertight}).report.reason,
        testing::StartsWith("asked for; closing adds 0.0 %"));
}

TEST(Reconstruct, StopsWhenToldTo) {
    std::stop_source source;
    Context context{.stop = source.get_token()};
    // At the first report after the triangulation.
    context.progress = [&](std::string_view, double fraction) {
        if (fraction >= 0.5) source.request_stop();
    };
    try {
        reconstruct(shapes::sphere_cloud(2000), {}, context);
        FAIL() << "went on";
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::kCancelled);
    }
}

}  // namespace
}  // namespace pointbake
