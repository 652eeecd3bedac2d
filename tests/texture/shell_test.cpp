#include "texture/shell.h"

#include <gtest/gtest.h>

#include "core/adjacency.h"
#include "core/hash.h"
#include "texture/footprints.h"

namespace pointbake {
namespace {

// A corner of three triangles that leans every vertex normal.
Mesh bent_mesh() {
    Mesh mesh;
    mesh.positions = {{0, 0, 0.5}, {1, 0, 0}, {-0.5, 0.9, 0}, {-0.5, -0.9, 0}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}};
    return mesh;
}

TEST(Shell, ProjectionInvertsTheInterpolatedNormalMap) {
    const Mesh mesh = bent_mesh();
    const Shell shell(mesh, Projection::kInterpolated, {});
    for (std::uint64_t i = 0; i < 300; ++i) {
        const double r1 = random_unit(1, i), r2 = random_unit(2, i),
                     depth = 0.2 * (random_unit(3, i) - 0.5);
        const Vec3d b{1 - std::max(r1, r2), std::min(r1, r2), std::max(r1, r2) - std::min(r1, r2)};
        const auto triangle = static_cast<Index>(i % 3);
        Vec3d p{};
        for (std::size_t k = 0; k < 3; ++k) {
            const Index v = mesh.triangles[triangle][k];
            p += (mesh.positions[v] + vec_cast<double>(shell.normals()[v]) * depth) * b[k];
        }
        const ShellPoint found = shell.project(triangle, p);
        EXPECT_NEAR(found.depth, depth, 1e-9);
        for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(found.barycentric[k], b[k], 1e-7);
    }
}

TEST(Shell, GradientIsTheDerivativeOfTheProjection) {
    const Mesh mesh = bent_mesh();
    const Shell shell(mesh, Projection::kInterpolated, {});
    const TriangleFrame& frame = shell.frame(0);
    const auto foot = [&](Vec3d p) {
        const Vec3d b = shell.project(0, p).barycentric;
        Vec2d x{};
        for (std::size_t k = 0; k < 3; ++k) x = x + frame.corners[k] * b[k];
        return x;
    };
    const Vec3d p{0.2, 0.3, 0.3};
    const ShellPoint at = shell.project(0, p);
    constexpr double kStep = 1e-6;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        Vec3d q = p;
        q[axis] += kStep;
        const Vec2d moved = (foot(q) - foot(p)) / kStep;
        EXPECT_NEAR(moved.x, at.gradient[0][axis], 1e-4);
        EXPECT_NEAR(moved.y, at.gradient[1][axis], 1e-4);
    }
}

TEST(Shell, FrameLaysTheLongestEdgeAlongX) {
    const Mesh mesh = bent_mesh();
    const TriangleFrame frame = triangle_frame(mesh, 0);
    for (std::size_t k = 0; k < 3; ++k) {
        const double in_plane = length(frame.corners[(k + 1) % 3] - frame.corners[k]);
        const Triangle& t = mesh.triangles[0];
        EXPECT_NEAR(in_plane, length(mesh.positions[t[(k + 1) % 3]] - mesh.positions[t[k]]), 1e-12);
        EXPECT_LE(in_plane, frame.base() + 1e-12);
    }
    EXPECT_GT(frame.height(), 0.0);
}

TEST(Shell, VertexNormalsLookOutOfEveryFaceAround) {
    // A steep pyramid: plain averages would do; a sharp fin would not.
    Mesh mesh;
    mesh.positions = {{0, 0, 3}, {1, 0.05, 0}, {-1, 0.05, 0}, {-1, -0.05, 0}, {1, -0.05, 0}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 1}};
    const std::vector<Vec3f> normals = shell_normals(mesh, {});
    for (Index t = 0; t < 4; ++t) {
        const TriangleFrame frame = triangle_frame(mesh, t);
        EXPECT_GT(dot(vec_cast<double>(normals[0]), frame.ez), 0.0) << "face " << t;
    }
}

// Places of the points over one triangle, in its plane, for a projection.
Vec2d painted_place(const Mesh& mesh, Vec3d p, float area, Projection projection) {
    PointCloud cloud;
    cloud.positions = {p};
    cloud.areas = {area};
    cloud.rows = {0};
    const Shell shell(mesh, projection, {});
    const Index owner = 0;
    const Footprints prints = project_points(mesh, cloud, {&owner, 1}, shell,
                                             triangle_neighbors(mesh.triangles), Kernel{}, {});
    EXPECT_EQ(prints.of(0).size(), 1U);
    const Vec2f center = prints.of(0)[0].center;
    return {static_cast<double>(center.x), static_cast<double>(center.y)};
}

TEST(Footprints, AreTwoThirdsOfTheWayToTheOrthogonalFoot) {
    const Mesh mesh = bent_mesh();
    const Shell shell(mesh, Projection::kInterpolated, {});
    const TriangleFrame& frame = shell.frame(0);
    const Vec3d p = frame.place({0.4 * frame.base(), 0.35 * frame.height()}) + frame.ez * 0.05;
    Vec2d along_normal{};
    for (std::size_t k = 0; k < 3; ++k)
        along_normal = along_normal + frame.corners[k] * shell.project(0, p).barycentric[k];
    const Vec2d orthogonal = painted_place(mesh, p, 1e-6F, Projection::kOrthographic);
    const Vec2d painted = painted_place(mesh, p, 1e-6F, Projection::kInterpolated);
    ASSERT_GT(length(orthogonal - along_normal), 0.01);
    EXPECT_NEAR(length(painted - along_normal), 2.0 / 3.0 * length(orthogonal - along_normal),
                1e-5);
    EXPECT_NEAR(length(painted - orthogonal), 1.0 / 3.0 * length(orthogonal - along_normal), 1e-5);
}

TEST(Footprints, AtTheWallOfAPrismStayThere) {
    const Mesh mesh = bent_mesh();
    const Shell shell(mesh, Projection::kInterpolated, {});
    // On the edge from the tip to corner 1, shared by triangles 0 and 2, and well above it.
    const Vec3d n = vec_cast<double>(shell.normals()[0]) + vec_cast<double>(shell.normals()[1]);
    const Vec3d p = (mesh.positions[0] + mesh.positions[1] + n * 0.3) * 0.5;
    const TriangleFrame& frame = shell.frame(0);
    const Vec2d edge = (frame.corners[0] + frame.corners[1]) * 0.5;
    const Vec2d orthogonal = painted_place(mesh, p, 1e-6F, Projection::kOrthographic);
    ASSERT_GT(length(orthogonal - edge), 0.05);
    const Vec2d painted = painted_place(mesh, p, 1e-4F, Projection::kInterpolated);
    EXPECT_LE(length(painted - edge), 1e-5);
}

}  // namespace
}  // namespace pointbake
