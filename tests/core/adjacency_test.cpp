#include "core/adjacency.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace pointbake {
namespace {

std::vector<Triangle> tetrahedron(Index a, Index b, Index c, Index d) {
    return {{a, c, b}, {a, b, d}, {b, c, d}, {c, a, d}};
}

std::vector<Triangle> torus(Index n, Index m) {
    std::vector<Triangle> out;
    const auto at = [&](Index i, Index j) { return (i % n) * m + j % m; };
    for (Index i = 0; i < n; ++i) {
        for (Index j = 0; j < m; ++j) {
            out.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
            out.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    }
    return out;
}

// n quads in a row: vertices 2 i and 2 i + 1 are a rung.
std::vector<Triangle> strip(Index n) {
    std::vector<Triangle> out;
    for (Index i = 0; i < n; ++i) {
        out.push_back({2 * i, 2 * i + 2, 2 * i + 1});
        out.push_back({2 * i + 1, 2 * i + 2, 2 * i + 3});
    }
    return out;
}

std::vector<Triangle> joined(std::vector<Triangle> a, const std::vector<Triangle>& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

TEST(Topology, OfATetrahedronIsASphere) {
    const Topology t = topology(4, tetrahedron(0, 1, 2, 3));
    EXPECT_TRUE(t.is_closed_manifold());
    EXPECT_EQ(t.num_vertices, 4U);
    EXPECT_EQ(t.num_edges, 6U);
    EXPECT_EQ(t.num_triangles, 4U);
    EXPECT_EQ(t.num_components, 1U);
    EXPECT_EQ(t.num_boundary_loops, 0U);
    EXPECT_EQ(t.euler(), 2);
}

TEST(Topology, OfATorusHasEulerNumberZero) {
    const Topology t = topology(7 * 5, torus(7, 5));
    EXPECT_TRUE(t.is_closed_manifold());
    EXPECT_EQ(t.euler(), 0);
    EXPECT_EQ(t.num_components, 1U);
}

TEST(Topology, SeesAVertexThatTwoFansShare) {
    const Topology t = topology(7, joined(tetrahedron(0, 1, 2, 3), tetrahedron(0, 4, 5, 6)));
    EXPECT_EQ(t.num_nonmanifold_vertices, 1U);
    EXPECT_EQ(t.num_nonmanifold_edges, 0U);
    EXPECT_EQ(t.num_components, 1U);
    EXPECT_FALSE(t.is_closed_manifold());
}

TEST(Topology, SeesAnEdgeOfFourTriangles) {
    const Topology t = topology(6, joined(tetrahedron(0, 1, 2, 3), tetrahedron(0, 1, 4, 5)));
    EXPECT_EQ(t.num_nonmanifold_edges, 1U);
    EXPECT_EQ(t.num_boundary_edges, 0U);
    EXPECT_FALSE(t.is_closed_manifold());
}

TEST(Topology, SeesTwoTrianglesOfOppositeOrientation) {
    const Topology t = topology(4, std::vector<Triangle>{{0, 1, 2}, {0, 1, 3}});
    EXPECT_EQ(t.num_nonmanifold_edges, 1U);
    EXPECT_EQ(t.num_boundary_edges, 4U);
}

TEST(Topology, OfAnOpenStripHasOneLoop) {
    const Topology t = topology(12, strip(5));
    EXPECT_EQ(t.num_vertices, 12U);
    EXPECT_EQ(t.num_boundary_edges, 12U);
    EXPECT_EQ(t.num_boundary_loops, 1U);
    EXPECT_EQ(t.num_nonmanifold_vertices, 0U);
    EXPECT_EQ(t.euler(), 1);
}

TEST(Topology, CountsComponentsAndIgnoresUnusedVertices) {
    const Topology t = topology(20, joined(tetrahedron(0, 1, 2, 3), tetrahedron(9, 10, 11, 19)));
    EXPECT_EQ(t.num_components, 2U);
    EXPECT_EQ(t.num_vertices, 8U);
    EXPECT_TRUE(t.is_closed_manifold());
    EXPECT_EQ(topology(3, {}).num_vertices, 0U);
}

TEST(TriangleNeighbors, AreMutualAcrossEachEdge) {
    const std::vector<Triangle> triangles = torus(4, 6);
    const auto neighbors = triangle_neighbors(triangles);
    for (Index t = 0; t < triangles.size(); ++t) {
        for (std::size_t k = 0; k < 3; ++k) {
            const Index other = neighbors[t][k];
            ASSERT_NE(other, kInvalidIndex);
            const Index a = triangles[t][k], b = triangles[t][(k + 1) % 3];
            bool is_back = false;
            for (std::size_t m = 0; m < 3; ++m)
                is_back |= neighbors[other][m] == t && triangles[other][m] == b &&
                           triangles[other][(m + 1) % 3] == a;
            EXPECT_TRUE(is_back);
        }
    }
}

TEST(TriangleNeighbors, EndAtBordersAndNonManifoldEdges) {
    const auto open = triangle_neighbors(std::vector<Triangle>{{0, 1, 2}});
    EXPECT_EQ(open[0], (std::array{kInvalidIndex, kInvalidIndex, kInvalidIndex}));
    const auto flipped = triangle_neighbors(std::vector<Triangle>{{0, 1, 2}, {0, 1, 3}});
    EXPECT_EQ(flipped[0][0], kInvalidIndex);
    const auto fin = triangle_neighbors(joined(tetrahedron(0, 1, 2, 3), tetrahedron(0, 1, 4, 5)));
    int num_open = 0;
    for (const auto& n : fin) num_open += static_cast<int>(std::ranges::count(n, kInvalidIndex));
    EXPECT_EQ(num_open, 4);
}

TEST(VertexTriangles, ListEachCornerOnceInOrder) {
    const std::vector<Triangle> triangles = strip(3);
    const VertexTriangles around = vertex_triangles(9, triangles);
    std::size_t total = 0;
    for (Index v = 0; v < 9; ++v) {
        const auto list = around.of(v);
        EXPECT_TRUE(std::ranges::is_sorted(list));
        for (const Index t : list) EXPECT_EQ(std::ranges::count(triangles[t], v), 1);
        total += list.size();
    }
    EXPECT_EQ(total, 3 * triangles.size());
    EXPECT_TRUE(around.of(8).empty());
}

TEST(Volume, OfATetrahedronIsASixthOfItsBox) {
    const Vec3d far{1e6, -2e6, 3e6};
    const std::vector<Vec3d> p{far, far + Vec3d{2, 0, 0}, far + Vec3d{0, 3, 0},
                               far + Vec3d{0, 0, 4}};
    EXPECT_NEAR(volume(p, tetrahedron(0, 1, 2, 3)), 4.0, 1e-9);
    EXPECT_NEAR(volume(p, tetrahedron(1, 0, 2, 3)), -4.0, 1e-9);
    EXPECT_EQ(volume({}, {}), 0.0);
}

}  // namespace
}  // namespace pointbake
