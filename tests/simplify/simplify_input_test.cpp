// Input that is not a neat closed surface over the cloud's points.
#include <gtest/gtest.h>

#include <algorithm>

#include "core/adjacency.h"
#include "pointbake/error.h"
#include "pointbake/simplify.h"
#include "simplify/dense_shapes.h"

namespace pointbake {
namespace {

using dense_shapes::brute_distance;
using dense_shapes::bumpy_sphere;
using dense_shapes::Input;
using dense_shapes::over;

ErrorCode code_of(const Input& input, const SimplifyOptions& options) {
    try {
        input.simplified(options);
    } catch (const Error& e) {
        return e.code();
    }
    ADD_FAILURE() << "no error";
    return ErrorCode::kCancelled;
}

// Sheets of n x n quads around the z axis from y = -1 to 1, all with the edge x = y = 0 in common.
Mesh book(int num_sheets, Index n) {
    Mesh mesh;
    for (Index v = 0; v <= n; ++v) mesh.positions.push_back({0, 0, 2.0 * v / n - 1.0});
    for (int s = 0; s < num_sheets; ++s) {
        const double angle = 2.0 * std::numbers::pi * s / num_sheets;
        const Index base = static_cast<Index>(mesh.positions.size());
        for (Index v = 0; v <= n; ++v) {
            for (Index u = 1; u <= n; ++u)
                mesh.positions.push_back(
                    {std::cos(angle) * u / n, std::sin(angle) * u / n, 2.0 * v / n - 1.0});
        }
        const auto at = [&](Index u, Index v) { return u == 0 ? v : base + v * n + u - 1; };
        for (Index v = 0; v < n; ++v) {
            for (Index u = 0; u < n; ++u) {
                mesh.triangles.push_back({at(u, v), at(u + 1, v), at(u + 1, v + 1)});
                mesh.triangles.push_back({at(u, v), at(u + 1, v + 1), at(u, v + 1)});
            }
        }
    }
    return mesh;
}

TEST(SimplifyInput, SheetsThatShareAnEdgeKeepIt) {
    const Mesh mesh = book(3, 10);
    const Input input = over(mesh);
    const SimplifyResult r = input.simplified({.geometry_error = fraction(0.001)});
    const Topology after = topology(r.mesh.positions.size(), r.mesh.triangles);
    EXPECT_EQ(after.num_components, 1U);
    EXPECT_GE(after.num_nonmanifold_edges, 1U);
    EXPECT_LE(after.num_triangles, 60U);
    for (Vec3d p : input.cloud.positions) EXPECT_LE(brute_distance(r.mesh, p), r.report.bound);
}

TEST(SimplifyInput, NonManifoldVerticesAndClashingTrianglesAreLeftAlone) {
    // Two spheres that share a vertex, and a strip whose halves are oriented against each other.
    Mesh mesh = bumpy_sphere(6, 1);
    const Index n = static_cast<Index>(mesh.positions.size());
    const Mesh other = bumpy_sphere(6, 2);
    const Vec3d shift = mesh.positions[0] - other.positions[n / 2];
    for (Vec3d p : other.positions) mesh.positions.push_back(p + shift);
    for (const Triangle& t : other.triangles) {
        Triangle moved;
        for (std::size_t k = 0; k < 3; ++k) moved[k] = t[k] == n / 2 ? 0 : t[k] + n;
        mesh.triangles.push_back(moved);
    }
    const Index base = static_cast<Index>(mesh.positions.size());
    for (Vec3d p : {Vec3d{9, 0, 0}, {9, 1, 0}, {10, 0, 0}, {8, 0, 0}}) mesh.positions.push_back(p);
    mesh.triangles.push_back({base, base + 1, base + 2});
    mesh.triangles.push_back({base, base + 1, base + 3});
    Input input = over(mesh);
    const SimplifyResult r = input.simplified({.geometry_error = fraction(0.003)});
    const Topology after = topology(r.mesh.positions.size(), r.mesh.triangles);
    EXPECT_EQ(after.num_components, 2U);
    EXPECT_EQ(after.num_nonmanifold_vertices, 1U);
    EXPECT_LT(after.num_triangles, mesh.triangles.size() / 2);
    // The second sphere's copy of the shared vertex is used by no triangle.
    for (std::size_t p = 0; p < input.cloud.size(); ++p) {
        if (r.point_triangles[p] != kInvalidIndex) {
            EXPECT_LE(brute_distance(r.mesh, input.cloud.positions[p]), r.report.bound);
        }
    }
}

TEST(SimplifyInput, DegenerateTrianglesVanish) {
    Mesh mesh = bumpy_sphere(8, 4);
    // Twice the same vertex, three collinear ones, a vertex that nobody uses.
    mesh.triangles.push_back({0, 0, 5});
    mesh.triangles.push_back({7, 7, 7});
    const Triangle cut = mesh.triangles[10];
    const Index middle = static_cast<Index>(mesh.positions.size());
    mesh.positions.push_back((mesh.positions[cut[0]] + mesh.positions[cut[1]]) * 0.5);
    mesh.triangles[10] = {middle, cut[1], cut[2]};
    mesh.triangles.push_back({cut[0], middle, cut[2]});
    mesh.triangles.push_back({cut[1], middle, cut[0]});
    mesh.positions.push_back(mesh.positions[3]);
    for (double f : {1e-6, 0.003}) {
        const SimplifyResult r = over(mesh).simplified({.geometry_error = fraction(f)});
        for (const Triangle& t : r.mesh.triangles) {
            const Vec3d a = r.mesh.positions[t[0]];
            EXPECT_GT(length(cross(r.mesh.positions[t[1]] - a, r.mesh.positions[t[2]] - a)), 0.0);
        }
        EXPECT_TRUE(r.report.bound_met);
    }
}

TEST(SimplifyInput, NothingInNothingOut) {
    const Input empty;
    EXPECT_TRUE(empty.simplified({}).mesh.triangles.empty());
    Input points_alone;
    points_alone.cloud.positions = {{0, 0, 0}, {1, 0, 0}};
    const SimplifyResult r = points_alone.simplified({});
    EXPECT_EQ(r.report.num_off_surface, 2U);
    EXPECT_EQ(r.point_triangles, (std::vector<Index>{kInvalidIndex, kInvalidIndex}));
    Input mesh_alone = over(bumpy_sphere(5, 1));
    mesh_alone.cloud = {};
    mesh_alone.dense.vertex_points.clear();
    EXPECT_LE(mesh_alone.simplified({.triangles = 50}).mesh.triangles.size(), 50U);
}

TEST(SimplifyInput, OneTriangleStays) {
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.triangles = {{0, 1, 2}};
    const SimplifyResult r = over(mesh).simplified({});
    EXPECT_EQ(r.mesh.positions, mesh.positions);
    EXPECT_EQ(r.mesh.triangles, mesh.triangles);
}

TEST(SimplifyInput, PointsThatAreNoVerticesCountForTheBound) {
    // A coarse sphere meets a cloud on the finer one: points are off the vertices by up to 1 %.
    Input input;
    input.dense.mesh = shapes::sphere_mesh(10);
    input.cloud = shapes::sphere_cloud(3000);
    const SimplifyResult r = input.simplified({.geometry_error = fraction(0.01)});
    EXPECT_EQ(r.report.num_off_surface, 0U);
    EXPECT_LT(r.mesh.triangles.size(), 500U);
    for (Vec3d p : input.cloud.positions) EXPECT_LE(brute_distance(r.mesh, p), r.report.bound);
}

TEST(SimplifyInput, PointsFartherThanTheBoundAreOffTheSurface) {
    Input input = over(bumpy_sphere(8, 6));
    const std::size_t n = input.cloud.size();
    input.cloud.positions.push_back({0.0, 0.0, 0.0});
    input.cloud.positions.push_back(input.cloud.positions[5] * 1.001);
    const SimplifyResult r = input.simplified({.geometry_error = fraction(0.005)});
    EXPECT_EQ(r.report.num_off_surface, 1U);
    EXPECT_EQ(r.point_triangles[n], kInvalidIndex);
    EXPECT_LT(r.point_triangles[n + 1], r.mesh.triangles.size());
    EXPECT_LE(r.report.points_to_mesh.max, r.report.bound);
    // Without a bound nothing is off.
    EXPECT_EQ(input.simplified({.triangles = 300}).report.num_off_surface, 0U);
}

TEST(SimplifyInput, TheDiagonalIsThatOfTheKeptPoints) {
    Input input = over(bumpy_sphere(8, 6));
    const double bound = input.simplified({.geometry_error = fraction(0.01)}).report.bound;
    input.cloud.positions.push_back({60.0, 0.0, 0.0});
    const SimplifyResult r = input.simplified({.geometry_error = fraction(0.01)});
    EXPECT_DOUBLE_EQ(r.report.bound, bound);
    EXPECT_EQ(r.report.num_off_surface, 1U);
}

TEST(SimplifyInput, CopiesOfAVertexShareTheirPoint) {
    // Two pyramids that touch at the apex, split there.
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 1, 1},  {-1, 1, 1},  {-1, -1, 1},  {1, -1, 1},
                      {0, 0, 0}, {1, 1, -1}, {-1, 1, -1}, {-1, -1, -1}, {1, -1, -1}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 1},
                      {5, 7, 6}, {5, 8, 7}, {5, 9, 8}, {5, 6, 9}};
    Input input;
    input.cloud.positions = mesh.positions;
    input.cloud.positions.erase(input.cloud.positions.begin() + 5);
    input.dense.mesh = mesh;
    input.dense.vertex_points = {0, 1, 2, 3, 4, 0, 5, 6, 7, 8};
    const SimplifyResult r = input.simplified({.geometry_error = fraction(0.001)});
    // Where one copy holds the point, the other pyramid need not keep its apex.
    EXPECT_GE(r.mesh.triangles.size(), 6U);
    EXPECT_EQ(r.report.num_off_surface, 0U);
    for (float d : r.point_distances) EXPECT_LT(d, 1e-6F);
}

TEST(SimplifyInput, PartsGoWhenTheBudgetCannotHoldThemAll) {
    // A large sphere and four small ones: sixteen triangles hold four of them at best.
    Mesh mesh;
    for (int s = 0; s < 5; ++s) {
        const Mesh part = bumpy_sphere(4, 1);
        const Index base = static_cast<Index>(mesh.positions.size());
        for (Vec3d p : part.positions)
            mesh.positions.push_back(p * (s == 2 ? 1.0 : 0.1 + 0.01 * s) + Vec3d{3.0 * s, 0, 0});
        for (const Triangle& t : part.triangles)
            mesh.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
    }
    const Input input = over(mesh);
    const SimplifyResult r = input.simplified({.triangles = 16});
    EXPECT_LE(r.mesh.triangles.size(), 16U);
    // The smallest go, and their points with them; the large one keeps most of the triangles.
    const std::size_t num_parts =
        topology(r.mesh.positions.size(), r.mesh.triangles).num_components;
    EXPECT_LT(num_parts, 5U);
    EXPECT_EQ(r.report.num_parts_removed, 5 - num_parts);
    const std::size_t part_size = bumpy_sphere(4, 1).positions.size();
    EXPECT_EQ(r.report.num_off_surface, (5 - num_parts) * part_size);
    const std::array by_size{0U, 1U, 3U, 4U, 2U};
    for (std::size_t rank = 0; rank < by_size.size(); ++rank)
        EXPECT_EQ(r.point_triangles[by_size[rank] * part_size] == kInvalidIndex,
                  rank < 5 - num_parts);
    const auto in_large = [&](const Triangle& t) {
        return r.mesh.positions[t[0]].x > 4.9 && r.mesh.positions[t[0]].x < 7.1;
    };
    EXPECT_GE(std::count_if(r.mesh.triangles.begin(), r.mesh.triangles.end(), in_large), 8);
    EXPECT_EQ(code_of(over(bumpy_sphere(4, 1)), {.triangles = 3}), ErrorCode::kLimit);
}

TEST(SimplifyInput, LargePartsGoAtLast) {
    // Two sheets with 25 holes each, which no collapse closes: the budget holds one of them.
    constexpr Index kSide = 31;
    Mesh mesh;
    for (const double scale : {1.0, 2.0}) {
        const auto base = static_cast<Index>(mesh.positions.size());
        for (Index v = 0; v < kSide * kSide; ++v)
            mesh.positions.push_back({scale * (v % kSide), scale * (v / kSide), 100.0 * scale});
        for (Index v = 0; v + kSide < kSide * kSide; ++v) {
            const Index x = v % kSide, y = v / kSide;
            if (x == kSide - 1 || (x % 6 == 3 && y % 6 == 3)) continue;
            const Index a = base + v;
            mesh.triangles.push_back({a, a + 1, a + kSide + 1});
            mesh.triangles.push_back({a, a + kSide + 1, a + kSide});
        }
    }
    const SimplifyResult r = over(mesh).simplified({.triangles = 150});
    EXPECT_LE(r.mesh.triangles.size(), 150U);
    EXPECT_EQ(r.report.num_parts_removed, 1U);
    for (Vec3d p : r.mesh.positions) EXPECT_NEAR(p.z, 200.0, 1e-3);
}

TEST(SimplifyInput, KeptMeshesStayAsTheyAre) {
    Input input;
    input.dense.mesh = shapes::sphere_mesh(6);
    input.dense.mesh.triangles.push_back({3, 3, 4});
    input.cloud = shapes::sphere_cloud(2000);
    const SimplifyResult r = input.simplified({.keep_mesh = true});
    EXPECT_EQ(r.mesh.positions, input.dense.mesh.positions);
    EXPECT_EQ(r.mesh.triangles, input.dense.mesh.triangles);
    EXPECT_EQ(r.report.num_off_surface, 0U);
    for (std::size_t p = 0; p < input.cloud.size(); ++p) {
        const Mesh one{r.mesh.positions, {r.mesh.triangles[r.point_triangles[p]]}, {}, {}, {}};
        EXPECT_NEAR(brute_distance(one, input.cloud.positions[p]), r.point_distances[p], 1e-6);
    }
    EXPECT_GT(r.report.points_to_mesh.max, 0.005);
}

TEST(SimplifyInput, WrongInputIsRefused) {
    Input input = over(bumpy_sphere(3, 1));
    EXPECT_EQ(code_of(input, {.geometry_error = units(0.0)}), ErrorCode::kInvalidOption);
    EXPECT_EQ(code_of(input, {.geometry_error = units(-1.0)}), ErrorCode::kInvalidOption);
    EXPECT_EQ(code_of(input, {.geometry_error = fraction(HUGE_VAL)}), ErrorCode::kInvalidOption);
    Input bad_vertex = input;
    bad_vertex.dense.mesh.triangles.push_back({0, 1, 100000});
    EXPECT_EQ(code_of(bad_vertex, {}), ErrorCode::kInvalidInput);
    Input bad_point = input;
    bad_point.dense.vertex_points[3] = 1000000;
    EXPECT_EQ(code_of(bad_point, {}), ErrorCode::kInvalidInput);
    Input too_few = input;
    too_few.dense.vertex_points.pop_back();
    EXPECT_EQ(code_of(too_few, {}), ErrorCode::kInvalidInput);
}

}  // namespace
}  // namespace pointbake
