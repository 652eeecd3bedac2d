// The parts of the stage: quadrics, triangle distances, the queue, the working mesh.
#include <gtest/gtest.h>

#include <set>

#include "core/hash.h"
#include "simplify/dense_shapes.h"
#include "simplify/face_frame.h"
#include "simplify/indexed_heap.h"
#include "simplify/legality.h"
#include "simplify/quadric.h"
#include "simplify/surface.h"

namespace pointbake {
namespace {

Vec3d random_point(std::uint64_t seed, std::uint64_t i) {
    return {random_unit(seed, 3 * i), random_unit(seed, 3 * i + 1), random_unit(seed, 3 * i + 2)};
}

TEST(Quadric, IsTheWeightedSumOfSquaredPlaneDistances) {
    Quadric q;
    const Vec3d x = random_point(1, 0);
    double expected = 0.0;
    for (std::uint64_t i = 1; i < 5; ++i) {
        const Vec3d n = normalized(random_point(2, i)), p = random_point(3, i);
        q.add_plane(n, p, static_cast<double>(i));
        expected += static_cast<double>(i) * dot(x - p, n) * dot(x - p, n);
    }
    EXPECT_NEAR(q(x), expected, 1e-12);
}

TEST(Quadric, MinimumOfACornerIsTheCorner) {
    Quadric q;
    const Vec3d corner{0.3, -0.2, 0.9};
    for (std::size_t k = 0; k < 3; ++k) {
        Vec3d n;
        n[k] = 1.0;
        q.add_plane(n, corner, 1.0 + static_cast<double>(k));
    }
    const Vec3d x = q.minimum_near({0.5, 0.1, 0.7}, 1e-3 * q.trace(), 3);
    EXPECT_LT(length(x - corner), 1e-6);
}

TEST(Quadric, MinimumOfAPlaneStaysAtTheAnchorsFoot) {
    Quadric q;
    q.add_plane({0, 0, 1}, {5, 6, 2}, 3.0);
    const Vec3d x = q.minimum_near({0.5, 0.1, 0.7}, 1e-3 * q.trace(), 3);
    EXPECT_NEAR(x.x, 0.5, 1e-15);
    EXPECT_NEAR(x.y, 0.1, 1e-15);
    EXPECT_NEAR(x.z, 2.0, 1e-6);
}

TEST(FaceFrame, DistancesAgreeWithTheGeneralFunction) {
    for (std::uint64_t i = 0; i < 500; ++i) {
        const Vec3d a = random_point(5, i), b = random_point(6, i), c = random_point(7, i);
        const Vec3d p = random_point(8, i) * 3.0 - Vec3d{1, 1, 1};
        const FaceFrame frame(a, b, c);
        const ClosestPoint expected = closest_point_on_triangle(p, a, b, c);
        EXPECT_NEAR(frame.squared_distance(p, HUGE_VAL), expected.squared_distance, 1e-12);
        const double limit = 0.5 * expected.squared_distance;
        EXPECT_GT(frame.squared_distance(p, limit), limit);
        const ClosestFoot foot = frame.foot(p);
        EXPECT_LT(length(foot.barycentric - expected.barycentric), 1e-9);
        EXPECT_LT(length(expected.point + foot.direction * foot.residual - p), 1e-9);
    }
}

TEST(FaceFrame, FlatTrianglesAreSegments) {
    const FaceFrame frame({0, 0, 0}, {2, 0, 0}, {1, 0, 0});
    EXPECT_TRUE(frame.is_flat());
    EXPECT_DOUBLE_EQ(frame.squared_distance({1, 3, 0}, HUGE_VAL), 9.0);
    EXPECT_DOUBLE_EQ(frame.squared_distance({3, 0, 0}, HUGE_VAL), 1.0);
}

TEST(IndexedHeap, AgreesWithASortedSet) {
    IndexedHeap heap(50);
    std::set<std::pair<float, Index>> expected;
    std::vector<float> costs(50, -1.0F);
    for (std::uint64_t i = 0; i < 4000; ++i) {
        const Index id = static_cast<Index>(hash64(1, i) % 50);
        if (costs[id] >= 0.0F) expected.erase({costs[id], id});
        if (hash64(2, i) % 3 == 0) {
            heap.remove(id);
            costs[id] = -1.0F;
        } else {
            costs[id] = static_cast<float>(hash64(3, i) % 20);
            heap.set(id, costs[id]);
            expected.insert({costs[id], id});
        }
        ASSERT_EQ(heap.empty(), expected.empty());
        if (expected.empty()) continue;
        ASSERT_EQ(heap.top().cost, expected.begin()->first);
        ASSERT_EQ(heap.top().id, expected.begin()->second);
    }
}

TEST(Surface, TellsInteriorBorderAndEverythingElse) {
    Mesh plane = shapes::plane_mesh(4, 4);
    // A third sheet on the inner edge 11 - 12.
    plane.positions.push_back({0, 1, 0});
    plane.triangles.push_back({11, 12, 25});
    const Surface surface(plane.positions, plane.triangles, {});
    EXPECT_EQ(surface.kinds[6], VertexKind::kInterior);
    EXPECT_EQ(surface.kinds[2], VertexKind::kCurve);
    EXPECT_EQ(surface.kinds[0], VertexKind::kCurve);
    EXPECT_EQ(surface.kinds[11], VertexKind::kFixed);
    EXPECT_EQ(surface.kinds[12], VertexKind::kFixed);
    EXPECT_EQ(surface.kinds[25], VertexKind::kCurve);
}

TEST(Surface, SpineOfABookIsACurve) {
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {0, 0, 1}, {0, 0, 2}};
    for (int s = 0; s < 3; ++s) {
        const Index n = static_cast<Index>(mesh.positions.size());
        for (int z = 0; z < 3; ++z)
            mesh.positions.push_back({std::cos(2.0 * s), std::sin(2.0 * s), double(z)});
        mesh.triangles.insert(mesh.triangles.end(),
                              {{0, n, 1}, {n, n + 1, 1}, {1, n + 1, 2}, {n + 1, n + 2, 2}});
    }
    const Surface surface(mesh.positions, mesh.triangles, {});
    EXPECT_EQ(surface.kinds[1], VertexKind::kCurve);
    EXPECT_EQ(surface.kinds[0], VertexKind::kFixed);
}

// Judges the collapse of b into a at a's place.
Verdict judged(const Mesh& mesh, Index a, Index b) {
    Surface surface(mesh.positions, mesh.triangles, {});
    const dense_shapes::Input input = dense_shapes::over(mesh);
    Attribution attribution =
        attribute_points(surface, mesh.positions, input.dense.vertex_points, {});
    attribution.link(surface.triangles.size(), HUGE_VAL);
    std::vector<std::uint8_t> marks(mesh.positions.size(), 0);
    BorderTrace trace(surface);
    return CollapseJudge(surface, attribution, trace, marks, HUGE_VAL)
        .judge(a, b, mesh.positions[a]);
}

TEST(CollapseJudge, RefusesToCloseTetrahedraHolesAndTubes) {
    Mesh tetrahedron;
    tetrahedron.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    tetrahedron.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
    EXPECT_EQ(judged(tetrahedron, 0, 1), Verdict::kTopology);
    // A triangular tube: its ends are not triangles of it.
    Mesh tube;
    for (int z = 0; z < 3; ++z) {
        for (int k = 0; k < 3; ++k)
            tube.positions.push_back({std::cos(2.1 * k), std::sin(2.1 * k), 1.0 * z});
    }
    for (Index z = 0; z < 2; ++z) {
        for (Index k = 0; k < 3; ++k) {
            const Index a = 3 * z + k, b = 3 * z + (k + 1) % 3;
            tube.triangles.insert(tube.triangles.end(), {{a, b, b + 3}, {a, b + 3, a + 3}});
        }
    }
    EXPECT_EQ(judged(tube, 0, 1), Verdict::kTopology);  // the open end
    EXPECT_EQ(judged(tube, 3, 4), Verdict::kTopology);  // the waist
    EXPECT_EQ(judged(tube, 0, 3), Verdict::kLegal);
    std::erase_if(tube.triangles, [](const Triangle& t) { return t[2] > 5 || t[1] > 5; });
    EXPECT_EQ(judged(tube, 0, 3), Verdict::kTopology);  // from one border to the other
}

TEST(CollapseJudge, RefusesToTurnTrianglesOver) {
    // The vertex 6 of the grid dragged across the border of its star.
    Mesh plane = shapes::plane_mesh(4, 4);
    EXPECT_EQ(judged(plane, 12, 6), Verdict::kLegal);
    plane.positions[8] = {0.1, 0.0, -0.4};
    plane.positions[6] = {-0.45, 0.0, 0.9};
    EXPECT_EQ(judged(plane, 8, 7), Verdict::kShape);
}

}  // namespace
}  // namespace pointbake
