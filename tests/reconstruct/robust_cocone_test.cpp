// Robust Cocone on closed shapes under noise of up to a whole spacing, beside Tight Cocone.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <string>

#include "core/adjacency.h"
#include "core/hash.h"
#include "pointbake/error.h"
#include "pointbake/reconstruct.h"
#include "support/shapes.h"

namespace pointbake {
namespace {

using shapes::add_point;

constexpr double kPi = std::numbers::pi;
constexpr std::uint64_t kPoints = 3000;
constexpr ReconstructOptions kRobust{.method = Method::kRobustCocone};

struct Shape {
    std::string name;
    PointCloud cloud;
    double spacing, volume;
    std::int64_t euler;
    std::function<double(Vec3d)> distance;  // signed, to the surface; positive outside
};

double bumpy_radius(Vec3d d) {
    return 1.0 + 0.15 * d.x * std::sin(6.0 * d.y) + 0.1 * std::cos(7.0 * d.z);
}

double cube_distance(Vec3d p) {
    const Vec3d q{std::fabs(p.x) - 1.0, std::fabs(p.y) - 1.0, std::fabs(p.z) - 1.0};
    const double nearest = std::max({q.x, q.y, q.z});
    if (nearest < 0.0) return nearest;
    return length(Vec3d{std::max(q.x, 0.0), std::max(q.y, 0.0), std::max(q.z, 0.0)});
}

Shape sphere() {
    return {"sphere",
            shapes::sphere_cloud(kPoints),
            std::sqrt(4.0 * kPi / kPoints),
            4.0 / 3.0 * kPi,
            2,
            [](Vec3d p) { return length(p) - 1.0; }};
}

Shape torus() {
    return {"torus",
            shapes::torus_cloud(kPoints),
            std::sqrt(4.0 * kPi * kPi * 0.4 / kPoints),
            2.0 * kPi * kPi * 0.4 * 0.4,
            0,
            [](Vec3d p) { return std::hypot(std::hypot(p.x, p.z) - 1.0, p.y) - 0.4; }};
}

Shape cube() {
    constexpr int kSide = 22;
    return {"cube", shapes::cube_cloud(kSide), 2.0 / kSide, 8.0, 2, cube_distance};
}

// Bumps, random points. The distance is the radial one, times the mean cosine of the slope.
Shape bumpy() {
    Shape shape{
        "bumpy", {}, std::sqrt(1.15 * 4.0 * kPi / kPoints),
        0.0,     2,  [](Vec3d p) {
                    return 0.9 * (length(p) - bumpy_radius(normalized(p))); }};
    for (std::uint64_t i = 0; i < kPoints; ++i) {
        const double z = 2.0 * random_unit(31, i) - 1.0, a = 2.0 * kPi * random_unit(32, i);
        const double r = std::sqrt(1.0 - z * z);
        const Vec3d d{r * std::cos(a), r * std::sin(a), z};
        add_point(shape.cloud, d * bumpy_radius(d), {});
    }
    constexpr std::uint64_t kRays = 20000;
    for (std::uint64_t i = 0; i < kRays; ++i) {
        const double r = bumpy_radius(shapes::fibonacci_direction(i, kRays));
        shape.volume += 4.0 / 3.0 * kPi * r * r * r / kRays;
    }
    return shape;
}

// Isotropic noise of that standard deviation.
PointCloud noisy(const PointCloud& cloud, double deviation) {
    PointCloud result = cloud;
    for (std::uint64_t i = 0; i < cloud.size(); ++i)
        for (std::size_t k = 0; k < 3; ++k)
            result.positions[i][k] += deviation * shapes::random_normal(91 + k, i);
    return result;
}

// How far a mesh is from the true surface, weighted by area.
struct Deviation {
    double mean_distance = 0.0, bias = 0.0;  // bias: outwards
    double mean_tilt_deg = 0.0;              // of the triangles' normals
};

Deviation deviation_of(const Mesh& mesh, const Shape& shape) {
    constexpr double kStep = 1e-4;
    Deviation sum;
    double total = 0.0;
    for (const Triangle& t : mesh.triangles) {
        const auto& p = mesh.positions;
        const Vec3d n = cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]);
        const Vec3d at = (p[t[0]] + p[t[1]] + p[t[2]]) / 3.0;
        Vec3d gradient;
        for (std::size_t k = 0; k < 3; ++k) {
            Vec3d step;
            step[k] = kStep;
            gradient[k] = shape.distance(at + step) - shape.distance(at - step);
        }
        const double area = 0.5 * length(n), d = shape.distance(at);
        const double cosine = dot(normalized(n), normalized(gradient));
        sum.mean_distance += area * std::fabs(d);
        sum.bias += area * d;
        sum.mean_tilt_deg += area * std::acos(std::clamp(cosine, -1.0, 1.0)) * 180.0 / kPi;
        total += area;
    }
    return {sum.mean_distance / total, sum.bias / total, sum.mean_tilt_deg / total};
}

// Nothing where the points enclose nothing.
std::optional<ReconstructResult> tight_cocone(const PointCloud& cloud) {
    try {
        return reconstruct(cloud, {.method = Method::kTightCocone});
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::kDegenerate);
        return std::nullopt;
    }
}

struct NoisyCase {
    Shape (*shape)();
    int noise_percent;  // of the spacing
};

class RobustCoconeNoise : public testing::TestWithParam<NoisyCase> {};

// The Euler number is right up to half a spacing at least; at a whole one, where Tight Cocone
// leaves splinters, it is recorded only.
TEST_P(RobustCoconeNoise, KeepsTheShape) {
    const Shape shape = GetParam().shape();
    const double noise = 0.01 * GetParam().noise_percent;
    PointCloud cloud = noisy(shape.cloud, noise * shape.spacing);
    cloud.noise = noise;
    const ReconstructResult r = reconstruct(cloud, kRobust);
    const Mesh& mesh = r.surface.mesh;
    const Topology t = topology(mesh.positions.size(), mesh.triangles);
    EXPECT_TRUE(t.is_closed_manifold());
    if (noise < 1.0) {
        EXPECT_EQ(t.euler(), shape.euler);
        EXPECT_EQ(t.num_components, 1U);
    }
    const Deviation d = deviation_of(mesh, shape);
    EXPECT_LT(d.mean_distance, (0.08 + 1.6 * noise) * shape.spacing);
    const double solid = volume(mesh.positions, mesh.triangles);
    const double area = static_cast<double>(cloud.size()) * shape.spacing * shape.spacing;
    EXPECT_NEAR(solid, shape.volume, 0.02 * shape.volume + 1.6 * noise * shape.spacing * area);
    RecordProperty("euler", static_cast<int>(t.euler()));
    RecordProperty("left_out", static_cast<int>(r.report.num_left_out));
    RecordProperty("volume_error_ppm", static_cast<int>(1e6 * (solid / shape.volume - 1.0)));
    RecordProperty("distance_ppm_of_spacing",
                   static_cast<int>(1e6 * d.mean_distance / shape.spacing));
    RecordProperty("bias_ppm_of_spacing", static_cast<int>(1e6 * d.bias / shape.spacing));
    RecordProperty("tilt_deg", static_cast<int>(d.mean_tilt_deg));
    const auto tight = tight_cocone(cloud);
    if (!tight) return;
    const Deviation other = deviation_of(tight->surface.mesh, shape);
    RecordProperty("tight_distance_ppm_of_spacing",
                   static_cast<int>(1e6 * other.mean_distance / shape.spacing));
    RecordProperty("tight_tilt_deg", static_cast<int>(other.mean_tilt_deg));
    if (noise >= 0.2) {
        EXPECT_LT(d.mean_tilt_deg, 0.8 * other.mean_tilt_deg);
    }
}

std::vector<NoisyCase> noisy_cases() {
    std::vector<NoisyCase> cases;
    for (const auto shape : {sphere, torus, cube, bumpy})
        for (const int percent : {0, 5, 10, 20, 30, 50, 100}) cases.push_back({shape, percent});
    return cases;
}

std::string case_name(const testing::TestParamInfo<NoisyCase>& c) {
    return c.param.shape().name + "_" + std::to_string(c.param.noise_percent);
}

INSTANTIATE_TEST_SUITE_P(Shapes, RobustCoconeNoise, testing::ValuesIn(noisy_cases()), case_name);

TEST(RobustCocone, KeepsEveryPointOfACleanSphere) {
    const PointCloud cloud = shapes::sphere_cloud(2000);
    const ReconstructResult r = reconstruct(cloud, kRobust);
    EXPECT_EQ(r.report.num_left_out, 0U);
    EXPECT_EQ(r.surface.mesh.triangles,
              reconstruct(cloud, {.method = Method::kTightCocone}).surface.mesh.triangles);
}

TEST(RobustCocone, LeavesOutWhatLiesInside) {
    PointCloud cloud = shapes::sphere_cloud(3000);
    for (const Vec3d& p : shapes::sphere_cloud(700, 0.0, 0.5).positions) add_point(cloud, p, {});
    const ReconstructResult r = reconstruct(cloud, kRobust);
    EXPECT_EQ(r.report.num_left_out, 700U);
    EXPECT_EQ(r.report.num_unused, 700U);
    EXPECT_EQ(r.report.num_components, 1U);
    EXPECT_THAT(r.report.reason, testing::HasSubstr("700 points"));
}

// Outer radius 1, height 2, walls and bottom 0.2 thick, open at the top.
Vec3d cup_point(std::uint64_t i) {
    constexpr double kInner = 0.8, kHeight = 2.0, kBottom = 0.2;
    const double areas[] = {2.0 * kHeight, 2.0 * kInner * (kHeight - kBottom), 1.0, kInner * kInner,
                            1.0 - kInner * kInner};
    double at = random_unit(51, i) * (areas[0] + areas[1] + areas[2] + areas[3] + areas[4]);
    std::size_t part = 0;
    while (part < 4 && at >= areas[part]) at -= areas[part++];
    const double t = random_unit(52, i), a = 2.0 * kPi * random_unit(53, i);
    const double radii[] = {1.0, kInner, std::sqrt(t), kInner * std::sqrt(t),
                            std::sqrt(kInner * kInner + t * areas[4])};
    const double heights[] = {kHeight * t, kBottom + (kHeight - kBottom) * t, 0.0, kBottom,
                              kHeight};
    return {radii[part] * std::cos(a), heights[part], radii[part] * std::sin(a)};
}

TEST(RobustCocone, GoesIntoACup) {
    PointCloud cloud;
    constexpr std::uint64_t kMany = 20000;
    for (std::uint64_t i = 0; i < kMany; ++i) add_point(cloud, cup_point(i), {});
    const double area = 2.0 * kPi * 2.0 + 2.0 * kPi * 0.8 * 1.8 + 2.0 * kPi;
    const double spacing = std::sqrt(area / kMany);
    const ReconstructResult r = reconstruct(noisy(cloud, 0.2 * spacing), kRobust);
    const Topology t = topology(r.surface.mesh.positions.size(), r.surface.mesh.triangles);
    EXPECT_TRUE(t.is_closed_manifold());
    EXPECT_EQ(t.euler(), 2);
    const double exact = kPi * (2.0 - 0.64 * 1.8);
    EXPECT_NEAR(volume(r.surface.mesh.positions, r.surface.mesh.triangles), exact, 0.1 * exact);
}

TEST(RobustCocone, IsWatertightWithoutBeingAsked) {
    const ReconstructResult r = reconstruct(shapes::half_sphere_cloud(2000), kRobust);
    EXPECT_EQ(r.report.surface, Surface::kWatertight);
    EXPECT_EQ(r.report.method, Method::kRobustCocone);
    EXPECT_EQ(r.report.num_boundary_loops, 0U);
}

TEST(RobustCocone, RefusesOpenSurfaces) {
    try {
        reconstruct(shapes::sphere_cloud(100),
                    {.surface = Surface::kOpen, .method = Method::kRobustCocone});
        FAIL() << "no error";
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::kInvalidOption);
        EXPECT_THAT(error.what(), testing::HasSubstr("robust-cocone"));
    }
}

// The triangles by coordinates, in an order of their own.
std::vector<std::array<std::array<double, 3>, 3>> triangle_set(const Mesh& mesh) {
    std::vector<std::array<std::array<double, 3>, 3>> set;
    for (const Triangle& t : mesh.triangles) {
        auto& corners = set.emplace_back();
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3d p = mesh.positions[t[k]];
            corners[k] = {p.x, p.y, p.z};
        }
        std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()),
                    corners.end());
    }
    std::sort(set.begin(), set.end());
    return set;
}

TEST(RobustCocone, DependsOnNeitherThreadsNorOrder) {
    const PointCloud cloud = noisy(shapes::sphere_cloud(3000), 0.03);
    PointCloud reversed;
    for (std::size_t i = cloud.size(); i > 0; --i) add_point(reversed, cloud.positions[i - 1], {});
    const ReconstructResult one = reconstruct(cloud, kRobust, {.threads = 1});
    const ReconstructResult seven = reconstruct(cloud, kRobust, {.threads = 7});
    EXPECT_EQ(one.surface.mesh.triangles, seven.surface.mesh.triangles);
    EXPECT_EQ(one.surface.vertex_points, seven.surface.vertex_points);
    EXPECT_EQ(triangle_set(one.surface.mesh),
              triangle_set(reconstruct(reversed, kRobust).surface.mesh));
}

TEST(RobustCocone, NamesThePointUnderEachVertex) {
    const PointCloud cloud = noisy(shapes::torus_cloud(3000), 0.03);
    const ReconstructResult r = reconstruct(cloud, kRobust);
    ASSERT_GT(r.report.num_left_out, 0U);
    for (std::size_t v = 0; v < r.surface.vertex_points.size(); ++v)
        EXPECT_EQ(cloud.positions[r.surface.vertex_points[v]], r.surface.mesh.positions[v]);
}

}  // namespace
}  // namespace pointbake
