#include <gtest/gtest.h>

#include "texture/planes.h"

namespace pointbake {
namespace {

Vec3d grey(double linear) {
    const double code = linear_to_srgb_exact(linear);
    return {code, code, code};
}

double linear_of(Rgb16 color) { return static_cast<double>(srgb_to_linear(color.r)); }

VertexColors colored(const Painted& p) {
    return color_vertices(p.mesh, p.cloud, p.owners, TextureOptions{});
}

TEST(VertexColors, AreMeansUnderTheHatsInLinearLight) {
    const Painted p = painted_square(200, [](double x, double) { return grey(x); });
    const VertexColors out = colored(p);
    // Integrals of x (1 - x) x and of (x - y) x over the triangles, by those of the weights.
    EXPECT_NEAR(linear_of(out.colors[0]), 3.0 / 8.0, 0.003);
    EXPECT_NEAR(linear_of(out.colors[1]), 3.0 / 4.0, 0.003);
    EXPECT_EQ(out.num_unseen, 0U);
}

TEST(VertexColors, PointsWeighAsMuchAsTheirAreas) {
    Painted p = painted_square(100, [](double, double) { return grey(0.0); });
    for (std::size_t i = 0; i < p.cloud.size(); ++i) {
        const bool is_white = (i + i / 100) % 2 == 0;
        p.cloud.colors[i] = is_white ? Rgb16{65535, 65535, 65535} : Rgb16{};
        p.cloud.areas[i] *= is_white ? 1.5F : 0.5F;
    }
    for (const Rgb16& c : colored(p).colors) EXPECT_NEAR(linear_of(c), 0.75, 0.01);
}

TEST(VertexColors, MeasureWhatTheTrianglesShow) {
    const Painted flat = painted_square(40, [](double, double) { return grey(0.3); });
    EXPECT_LT(colored(flat).rms, 0.1);
    // Black and white stripes: the mesh shows their mean, linear light of a half.
    const Painted striped = painted_square(
        40, [](double x, double) { return grey(static_cast<int>(x * 40) % 2 == 0 ? 1.0 : 0.0); });
    const double half = 255.0 * linear_to_srgb_exact(0.5);
    const double expected = std::sqrt(0.5 * (half * half + (255 - half) * (255 - half)));
    const VertexColors out = colored(striped);
    EXPECT_NEAR(out.rms, expected, 0.03 * expected);
    EXPECT_GE(out.p99, out.rms);
}

TEST(VertexColors, ComeFromNeighboursWhereNoPointIs) {
    Painted p = painted_square(30, [](double, double) { return grey(0.3); });
    // A strip of triangles that leads away from the points.
    p.mesh.positions.insert(p.mesh.positions.end(), {{2, 0, 0}, {2, 1, 0}, {3, 0, 0}});
    p.mesh.triangles.insert(p.mesh.triangles.end(), {{1, 4, 2}, {4, 5, 2}, {4, 6, 5}});
    const VertexColors out = colored(p);
    EXPECT_EQ(out.num_unseen, 3U);
    for (const Rgb16& c : out.colors) EXPECT_NEAR(linear_of(c), 0.3, 0.001);
}

TEST(VertexColors, AreNotOfPointsUnderAnotherLayer) {
    Painted p = painted_square(60, [](double, double) { return grey(0.8); });
    const std::size_t num_points = p.cloud.size();
    for (std::size_t i = 0; i < num_points; ++i) {  // a black layer below
        p.cloud.positions.push_back(p.cloud.positions[i] - Vec3d{0, 0, 0.2});
        p.cloud.colors.push_back({});
        p.cloud.normals.push_back(p.cloud.normals[i]);
        p.cloud.areas.push_back(p.cloud.areas[i]);
        p.cloud.rows.push_back(p.cloud.rows.size());
        p.owners.push_back(p.owners[i]);
    }
    for (const Rgb16& c : colored(p).colors) EXPECT_NEAR(linear_of(c), 0.8, 0.01);
}

}  // namespace
}  // namespace pointbake
