// What the light mesh looks like and how far it is.
#include "pointbake/simplify.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <stop_token>

#include "core/adjacency.h"
#include "core/bvh.h"
#include "pointbake/error.h"
#include "simplify/dense_shapes.h"

namespace pointbake {
namespace {

using dense_shapes::brute_distance;
using dense_shapes::bumpy_sphere;
using dense_shapes::Input;
using dense_shapes::over;

constexpr SimplifyOptions bound_of(double f) { return {.geometry_error = fraction(f)}; }

Topology topology_of(const Mesh& mesh) { return topology(mesh.positions.size(), mesh.triangles); }

void expect_clean(const Mesh& mesh) {
    std::vector<bool> used(mesh.positions.size(), false);
    for (const Triangle& t : mesh.triangles) {
        for (Index v : t) {
            ASSERT_LT(v, mesh.positions.size());
            used[v] = true;
        }
        const Vec3d a = mesh.positions[t[0]];
        EXPECT_GT(length(cross(mesh.positions[t[1]] - a, mesh.positions[t[2]] - a)), 0.0);
    }
    EXPECT_TRUE(std::all_of(used.begin(), used.end(), [](bool b) { return b; }));
    for (Vec3d p : mesh.positions) EXPECT_TRUE(is_finite(p));
}

TEST(Simplify, PlaneBecomesTwoTrianglesAndKeepsItsCorners) {
    Mesh plane = shapes::plane_mesh(30, 30);
    for (Index v = 0; v < plane.positions.size(); ++v) {
        Vec3d& p = plane.positions[v];
        if (std::abs(p.x) < 0.99) p.x += 0.02 * (random_unit(3, v) - 0.5);
        if (std::abs(p.z) < 0.99) p.z += 0.02 * (random_unit(4, v) - 0.5);
    }
    const SimplifyResult r = over(plane).simplified(bound_of(0.001));
    EXPECT_EQ(r.mesh.triangles.size(), 2U);
    for (Vec3d p : r.mesh.positions) {
        EXPECT_NEAR(std::abs(p.x), 1.0, 1e-9);
        EXPECT_NEAR(std::abs(p.z), 1.0, 1e-9);
        EXPECT_NEAR(p.y, 0.0, 1e-12);
    }
    EXPECT_LT(r.report.points_to_mesh.max, 1e-9);
}

TEST(Simplify, CubeBecomesTwelveTrianglesAndKeepsItsCorners) {
    const SimplifyResult r = over(dense_shapes::fine_cube(10)).simplified(bound_of(0.001));
    EXPECT_EQ(r.mesh.triangles.size(), 12U);
    ASSERT_EQ(r.mesh.positions.size(), 8U);
    for (Vec3d p : r.mesh.positions) {
        for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(std::abs(p[k]), 1.0, 1e-6);
    }
    EXPECT_TRUE(topology_of(r.mesh).is_closed_manifold());
    EXPECT_NEAR(volume(r.mesh.positions, r.mesh.triangles), 8.0, 1e-5);
}

TEST(Simplify, KeptPointsAreWithinTheBoundByBruteForce) {
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        const Input input = over(bumpy_sphere(8, seed));
        const double f = seed % 2 == 0 ? 0.002 : 0.01;
        const SimplifyResult r = input.simplified(bound_of(f));
        expect_clean(r.mesh);
        EXPECT_TRUE(r.report.bound_met);
        Box box;
        for (Vec3d p : input.cloud.positions) box.extend(p);
        EXPECT_DOUBLE_EQ(r.report.bound, f * box.diagonal());
        double worst = 0.0;
        for (Vec3d p : input.cloud.positions) worst = std::max(worst, brute_distance(r.mesh, p));
        EXPECT_LE(worst, r.report.bound) << "seed " << seed;
        EXPECT_NEAR(worst, r.report.points_to_mesh.max, 1e-12);
        EXPECT_LT(r.mesh.triangles.size(), input.dense.mesh.triangles.size());
    }
}

TEST(Simplify, BoundHoldsAfterRoundingToFloats) {
    const Input input = over(bumpy_sphere(10, 5));
    SimplifyResult r = input.simplified(bound_of(0.0005));
    for (Vec3d& p : r.mesh.positions) p = vec_cast<double>(vec_cast<float>(p));
    for (Vec3d p : input.cloud.positions) EXPECT_LE(brute_distance(r.mesh, p), r.report.bound);
}

TEST(Simplify, LooserBoundsNeedFewerTriangles) {
    const Input input = over(bumpy_sphere(14, 7));
    std::size_t before = input.dense.mesh.triangles.size() + 1;
    for (double f : {0.0002, 0.001, 0.004, 0.02, 0.1}) {
        const std::size_t n = input.simplified(bound_of(f)).mesh.triangles.size();
        EXPECT_LT(n, before) << f;
        before = n;
    }
}

TEST(Simplify, ClosedSurfacesKeepTheirGenus) {
    for (const Mesh& mesh : {shapes::torus_mesh(36, 72), bumpy_sphere(12, 3)}) {
        const Topology before = topology_of(mesh);
        for (double f : {0.002, 0.02}) {
            const Topology after = topology_of(over(mesh).simplified(bound_of(f)).mesh);
            EXPECT_TRUE(after.is_closed_manifold());
            EXPECT_EQ(after.euler(), before.euler());
            EXPECT_EQ(after.num_components, before.num_components);
            EXPECT_LT(after.num_triangles, before.num_triangles / 2);
        }
    }
}

TEST(Simplify, BorderLoopsStayAndStayInPlace) {
    // A half torus: a bent tube, open at both ends, with a hole in its side.
    Mesh tube = shapes::torus_mesh(32, 64);
    std::erase_if(tube.triangles, [&](const Triangle& t) {
        const Vec3d c = (tube.positions[t[0]] + tube.positions[t[1]] + tube.positions[t[2]]) / 3.0;
        return c.z < 0.0 || length(c - Vec3d{0.0, 0.4, 1.0}) < 0.2;
    });
    tube = dense_shapes::without_unused(tube);
    const SimplifyResult r = over(tube).simplified(bound_of(0.002));
    const Topology before = topology_of(tube), after = topology_of(r.mesh);
    EXPECT_EQ(after.num_boundary_loops, 3U);
    EXPECT_EQ(after.euler(), before.euler());
    EXPECT_EQ(after.num_nonmanifold_edges + after.num_nonmanifold_vertices, 0U);
    EXPECT_LT(after.num_triangles, before.num_triangles / 2);
    for (Vec3d p : tube.positions) EXPECT_LE(brute_distance(r.mesh, p), r.report.bound);
    for (Vec3d p : r.mesh.positions) EXPECT_GT(p.z, -0.1);
}

struct Segment {
    Vec3d from, to;
};

std::vector<Segment> borders_of(const Mesh& mesh) {
    std::multiset<std::pair<Index, Index>> edges;
    for (const Triangle& t : mesh.triangles)
        for (std::size_t k = 0; k < 3; ++k) edges.insert({t[k], t[(k + 1) % 3]});
    std::vector<Segment> out;
    for (const auto& [v, w] : edges)
        if (!edges.contains({w, v})) out.push_back({mesh.positions[v], mesh.positions[w]});
    return out;
}

/// Largest distance of points on the first borders to the others.
double farthest(const std::vector<Segment>& from, const std::vector<Segment>& to) {
    double worst = 0.0;
    for (const Segment& s : from) {
        for (const double at : {0.0, 0.25, 0.5, 0.75}) {
            double best = HUGE_VAL;
            for (const Segment& o : to)
                best = std::min(best, closest_point_on_triangle(s.from + (s.to - s.from) * at,
                                                                o.from, o.to, o.to)
                                          .squared_distance);
            worst = std::max(worst, best);
        }
    }
    return std::sqrt(worst);
}

// Points alone do not tell that a triangle covers a hole.
TEST(Simplify, BordersStayWithinTheBound) {
    Mesh plate = shapes::plane_mesh(40, 40);
    std::erase_if(plate.triangles, [&](const Triangle& t) {
        const Vec3d c =
            (plate.positions[t[0]] + plate.positions[t[1]] + plate.positions[t[2]]) / 3.0;
        return length(c) < 0.5;
    });
    plate = dense_shapes::without_unused(plate);
    const SimplifyResult r = over(plate).simplified(bound_of(0.02));
    const auto dense = borders_of(plate), light = borders_of(r.mesh);
    EXPECT_LT(light.size(), dense.size() / 4);
    EXPECT_LE(farthest(dense, light), r.report.bound * 1.0001);
    EXPECT_LE(farthest(light, dense), r.report.bound * 1.0001);
}

TEST(Simplify, TessellationDoesNotMatter) {
    // A dome over a grid whose columns are 16 times finer on one side.
    Mesh dome;
    std::vector<double> us;
    for (int i = 0; i < 16; ++i) us.push_back(-1.0 + i / 16.0);
    for (int i = 0; i <= 256; ++i) us.push_back(i / 256.0);
    const Index nu = static_cast<Index>(us.size()) - 1, nv = 32;
    for (Index v = 0; v <= nv; ++v) {
        for (double u : us) {
            const double w = 2.0 * v / nv - 1.0;
            dome.positions.push_back({u, w, 0.4 * (2.0 - u * u - w * w)});
        }
    }
    dome.triangles = shapes::grid_triangles(nu, nv, false);
    const SimplifyResult r = over(dome).simplified(bound_of(0.001));
    double coarse = 0.0, fine = 0.0;
    for (Vec3d p : r.mesh.positions) (p.x < 0.0 ? coarse : fine) += 1.0;
    EXPECT_GT(coarse, 50.0);
    EXPECT_NEAR(fine / coarse, 1.0, 0.15);
}

TEST(Simplify, BudgetIsNeverExceededAndNearlyUsed) {
    const Input input = over(bumpy_sphere(12, 9));
    for (Index n : {4U, 5U, 17U, 100U, 333U, 1000U}) {
        const SimplifyResult r = input.simplified({.triangles = n});
        EXPECT_LE(r.mesh.triangles.size(), n);
        EXPECT_GE(r.mesh.triangles.size() + 1, n);
        expect_clean(r.mesh);
        EXPECT_TRUE(r.report.bound_met);
        EXPECT_EQ(r.report.bound, HUGE_VAL);
        EXPECT_TRUE(topology_of(r.mesh).is_closed_manifold());
    }
}

TEST(Simplify, BudgetsTurnNoTriangleOverWhereRulesCanBeKept) {
    for (std::uint64_t seed : {4U, 9U}) {
        const Input input = over(bumpy_sphere(20, seed));
        for (Index n : {200U, 600U, 1500U}) {
            const Mesh mesh = input.simplified({.triangles = n}).mesh;
            for (const Triangle& t : mesh.triangles) {
                const Vec3d a = mesh.positions[t[0]], b = mesh.positions[t[1]],
                            c = mesh.positions[t[2]];
                EXPECT_GT(dot(cross(b - a, c - a), a + b + c), 0.0) << seed << " " << n;
            }
        }
    }
}

TEST(Simplify, BudgetAndBoundTogetherStopAtWhicheverComesFirst) {
    const Input input = over(bumpy_sphere(12, 9));
    const std::size_t by_bound = input.simplified(bound_of(0.002)).mesh.triangles.size();
    SimplifyOptions options = bound_of(0.002);
    options.triangles = static_cast<Index>(by_bound) * 2;
    SimplifyResult r = input.simplified(options);
    EXPECT_LE(r.mesh.triangles.size(), options.triangles);
    EXPECT_GE(r.mesh.triangles.size() + 1, options.triangles);
    EXPECT_TRUE(r.report.bound_met);
    EXPECT_LE(r.report.points_to_mesh.max, r.report.bound);

    options.triangles = static_cast<Index>(by_bound) / 3;
    r = input.simplified(options);
    EXPECT_LE(r.mesh.triangles.size(), options.triangles);
    EXPECT_FALSE(r.report.bound_met);
}

TEST(Simplify, FittedSphereIsNeitherInsideNorOutside) {
    const Input input = over(shapes::sphere_mesh(20));
    const SimplifyResult r = input.simplified({.triangles = 300});
    // With vertices on the sphere the volume would be 2.4 % too small.
    EXPECT_NEAR(volume(r.mesh.positions, r.mesh.triangles) / (4.0 / 3.0 * std::numbers::pi), 1.0,
                0.006);
    EXPECT_LT(r.report.points_to_mesh.mean, 0.0045);
}

TEST(Simplify, EveryPointHasItsNearestTriangle) {
    const Input input = over(bumpy_sphere(10, 11));
    const SimplifyResult r = input.simplified({.triangles = 200});
    for (std::size_t p = 0; p < input.cloud.size(); ++p) {
        ASSERT_LT(r.point_triangles[p], r.mesh.triangles.size());
        const Mesh one{r.mesh.positions, {r.mesh.triangles[r.point_triangles[p]]}, {}, {}, {}};
        const double own = brute_distance(one, input.cloud.positions[p]);
        EXPECT_NEAR(own, r.point_distances[p], 1e-6);
        EXPECT_NEAR(own, brute_distance(r.mesh, input.cloud.positions[p]), 1e-6);
    }
}

TEST(Simplify, PointsOfAThinSheetStayOnTheirSide) {
    // A plate much thinner than the bound: upper and lower side touch at its rim alone.
    Mesh plate = dense_shapes::fine_cube(14);
    for (Vec3d& p : plate.positions) p.y *= 0.002;
    const Input input = over(plate);
    const SimplifyResult r = input.simplified(bound_of(0.01));
    EXPECT_LT(r.mesh.triangles.size(), 200U);
    for (std::size_t p = 0; p < input.cloud.size(); ++p) {
        const Vec3d x = input.cloud.positions[p];
        if (std::abs(x.x) > 0.9 || std::abs(x.z) > 0.9) continue;
        const Triangle& t = r.mesh.triangles[r.point_triangles[p]];
        const Vec3d a = r.mesh.positions[t[0]];
        const Vec3d n = cross(r.mesh.positions[t[1]] - a, r.mesh.positions[t[2]] - a);
        EXPECT_GT(n.y * x.y, 0.0);
    }
}

TEST(Simplify, NumbersOfThreadsGiveTheSameBytes) {
    const Input input = over(bumpy_sphere(28, 13));
    for (const SimplifyOptions& options :
         {SimplifyOptions{.triangles = 700}, SimplifyOptions{bound_of(0.001)}}) {
        const SimplifyResult one = input.simplified(options, {.threads = 1});
        for (int threads : {1, 2, 7}) {
            const SimplifyResult r = input.simplified(options, {.threads = threads});
            EXPECT_EQ(r.mesh.positions, one.mesh.positions);
            EXPECT_EQ(r.mesh.triangles, one.mesh.triangles);
            EXPECT_EQ(r.point_triangles, one.point_triangles);
            EXPECT_EQ(r.point_distances, one.point_distances);
            EXPECT_EQ(r.report.mesh_to_surface.mean, one.report.mesh_to_surface.mean);
        }
    }
}

TEST(Simplify, ScaleByAPowerOfTwoChangesNothing) {
    Input input = over(bumpy_sphere(10, 15));
    const SimplifyResult r = input.simplified(bound_of(0.002));
    for (Vec3d& p : input.cloud.positions) p = p * 1024.0;
    for (Vec3d& p : input.dense.mesh.positions) p = p * 1024.0;
    const SimplifyResult big = input.simplified(bound_of(0.002));
    EXPECT_EQ(big.mesh.triangles, r.mesh.triangles);
    EXPECT_EQ(big.point_triangles, r.point_triangles);
}

TEST(Simplify, LargeCoordinatesLoseNothing) {
    Input input = over(bumpy_sphere(10, 15));
    const std::size_t n = input.simplified(bound_of(0.002)).mesh.triangles.size();
    const Vec3d far{652000.0, 4500000.0, 300.0};
    for (Vec3d& p : input.cloud.positions) p += far;
    for (Vec3d& p : input.dense.mesh.positions) p += far;
    const SimplifyResult r = input.simplified(bound_of(0.002));
    EXPECT_NEAR(static_cast<double>(r.mesh.triangles.size()), static_cast<double>(n),
                0.03 * double(n));
    EXPECT_TRUE(r.report.bound_met);
    for (Vec3d p : input.cloud.positions) EXPECT_LE(brute_distance(r.mesh, p), r.report.bound);
}

TEST(Simplify, ReportsDistancesOfTheMeshToTheSurface) {
    const Input input = over(shapes::sphere_mesh(16));
    const SimplifyResult r = input.simplified({.triangles = 100});
    // The light mesh is within a few percent of the sphere; the maximum includes the slack.
    EXPECT_GT(r.report.mesh_to_surface.mean, 0.002);
    EXPECT_LT(r.report.mesh_to_surface.mean, 0.03);
    EXPECT_GE(r.report.mesh_to_surface.max, r.report.mesh_to_surface.rms);
    double worst_vertex = 0.0;
    for (Vec3d p : r.mesh.positions)
        worst_vertex = std::max(worst_vertex, brute_distance(input.dense.mesh, p));
    EXPECT_GE(r.report.mesh_to_surface.max, worst_vertex);
    EXPECT_EQ(r.report.num_triangles, r.mesh.triangles.size());
    EXPECT_EQ(r.report.num_vertices, r.mesh.positions.size());
    EXPECT_EQ(r.report.num_triangles_before, input.dense.mesh.triangles.size());
}

TEST(Simplify, StopsWhenCancelled) {
    const Input input = over(bumpy_sphere(20, 1));
    std::stop_source before;
    before.request_stop();
    EXPECT_THROW(input.simplified({}, {.stop = before.get_token()}), Error);
    // And in the middle of the work.
    std::stop_source later;
    Context context{.threads = 2, .stop = later.get_token()};
    context.progress = [&](std::string_view, double f) {
        if (f > 0.2) later.request_stop();
    };
    try {
        input.simplified({}, context);
        FAIL() << "not cancelled";
    } catch (const Error& e) {
        EXPECT_EQ(e.code(), ErrorCode::kCancelled);
    }
}

TEST(Simplify, ProgressNeverGoesBack) {
    double last = -1.0;
    Context context{.threads = 1};
    context.progress = [&](std::string_view stage, double f) {
        EXPECT_EQ(stage, "simplify");
        EXPECT_GE(f, last);
        EXPECT_LE(f, 1.0);
        last = f;
    };
    SimplifyOptions options = bound_of(0.001);
    options.triangles = 30;
    over(bumpy_sphere(14, 2)).simplified(options, context);
    EXPECT_EQ(last, 1.0);
}

}  // namespace
}  // namespace pointbake
