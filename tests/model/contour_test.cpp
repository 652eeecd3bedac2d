#include "model/contour.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/adjacency.h"
#include "pointbake/error.h"

namespace pointbake {
namespace {

double ball(Vec3d p) { return length(p) - 0.8; }
Vec3d ball_normal(Vec3d p) { return normalized(p); }

// A cube whose planes lie askew in the lattice.
double cube(Vec3d p) { return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) - 0.7; }
Vec3d cube_normal(Vec3d p) {
    const Vec3d a{std::abs(p.x), std::abs(p.y), std::abs(p.z)};
    const std::size_t k = a.x >= a.y && a.x >= a.z ? 0 : (a.y >= a.z ? 1 : 2);
    Vec3d n;
    n[k] = p[k] > 0.0 ? 1.0 : -1.0;
    return n;
}

constexpr ContourGrid kGrid{{-1.03, -1.02, -1.01}, 1.0 / 12.0, {4, 4, 4}};

TEST(Contour, MakesARoundBall) {
    const Mesh mesh = contour({&ball, &ball_normal}, kGrid);
    const Topology t = topology(mesh.positions.size(), mesh.triangles);
    EXPECT_TRUE(t.is_closed_manifold());
    EXPECT_EQ(t.euler(), 2);
    for (const Vec3d& p : mesh.positions) ASSERT_NEAR(length(p), 0.8, 1e-6);
    EXPECT_NEAR(volume(mesh.positions, mesh.triangles), 4.0 / 3.0 * 3.14159265 * 0.512, 0.02);
}

TEST(Contour, KeepsEdgesAndCornersOfACube) {
    const Mesh mesh = contour({&cube, &cube_normal}, kGrid);
    EXPECT_TRUE(topology(mesh.positions.size(), mesh.triangles).is_closed_manifold());
    // Chamfers or rounding would lose volume.
    EXPECT_NEAR(volume(mesh.positions, mesh.triangles), 1.4 * 1.4 * 1.4, 1e-9);
    int corners = 0;
    for (const Vec3d& p : mesh.positions)
        corners += std::abs(std::abs(p.x) - 0.7) + std::abs(std::abs(p.y) - 0.7) +
                       std::abs(std::abs(p.z) - 0.7) <
                   1e-9;
    EXPECT_EQ(corners, 8);
}

TEST(Contour, IsTheSameForAnyNumberOfThreads) {
    Context one, seven;
    one.threads = 1;
    seven.threads = 7;
    const Mesh a = contour({&ball, &ball_normal}, kGrid, one);
    const Mesh b = contour({&ball, &ball_normal}, kGrid, seven);
    EXPECT_EQ(a.positions, b.positions);
    EXPECT_EQ(a.triangles, b.triangles);
}

TEST(Contour, OfNothingIsEmpty) {
    const Mesh mesh = contour({[](Vec3d) { return 1.0; }, &ball_normal}, kGrid);
    EXPECT_TRUE(mesh.positions.empty());
    EXPECT_TRUE(mesh.triangles.empty());
}

TEST(Contour, StopsWhenCancelled) {
    std::stop_source stop;
    stop.request_stop();
    Context context;
    context.stop = stop.get_token();
    try {
        contour({&ball, &ball_normal}, kGrid, context);
        FAIL() << "went on";
    } catch (const Error& e) {
        EXPECT_EQ(e.code(), ErrorCode::kCancelled);
    }
}

}  // namespace
}  // namespace pointbake
