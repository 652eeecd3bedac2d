// Which way open surfaces face: sensors, then the file's normals, then outwards.
#include <gtest/gtest.h>

#include <limits>

#include "core/adjacency.h"
#include "core/hash.h"
#include "pointbake/attributes.h"
#include "pointbake/reconstruct.h"
#include "support/shapes.h"

namespace pointbake {
namespace {

constexpr std::uint64_t kPoints = 2000;

PointCloud half_sphere(double sign) {
    PointCloud cloud = shapes::half_sphere_cloud(kPoints);
    for (Vec3f& n : cloud.normals) n = n * static_cast<float>(sign);
    return cloud;
}

PointCloud with_random_signs() {
    PointCloud cloud = half_sphere(1.0);
    for (std::size_t i = 0; i < cloud.size(); ++i)
        if (random_unit(31, i) < 0.5) cloud.normals[i] = -cloud.normals[i];
    return cloud;
}

ReconstructResult faced(PointCloud cloud, Surface surface = Surface::kOpen) {
    return reconstruct(estimate_attributes(std::move(cloud)).cloud, {.surface = surface});
}

// Share of the triangles that face away from the origin.
double outward(const ReconstructResult& r) {
    const auto& p = r.surface.mesh.positions;
    double count = 0.0;
    for (const Triangle& t : r.surface.mesh.triangles)
        count += dot(cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]), p[t[0]]) > 0.0 ? 1.0 : 0.0;
    return count / static_cast<double>(r.surface.mesh.triangles.size());
}

TEST(Facing, FollowsTheNormalsOfTheFile) {
    const ReconstructResult out = faced(half_sphere(1.0)), in = faced(half_sphere(-1.0));
    EXPECT_EQ(outward(out), 1.0);
    EXPECT_EQ(outward(in), 0.0);
    EXPECT_EQ(out.report.num_turned_pieces, 0U);
    EXPECT_EQ(in.report.num_turned_pieces, 1U);
    EXPECT_TRUE(in.unsure_normals.empty());
    EXPECT_TRUE(std::ranges::is_sorted(in.surface.mesh.triangles));
    EXPECT_EQ(
        topology(in.surface.mesh.positions.size(), in.surface.mesh.triangles).num_nonmanifold_edges,
        0U);
}

TEST(Facing, EstimatedNormalsSayNothing) {
    PointCloud cloud = half_sphere(-1.0);
    cloud.normals.clear();
    EXPECT_EQ(outward(faced(cloud)), 1.0);
    // Nor do those in the gaps of a file's normals.
    cloud = half_sphere(-1.0);
    for (std::size_t i = 0; i < cloud.size(); ++i)
        if (i % 4 != 0)
            cloud.normals[i] =
                i % 4 == 1 ? Vec3f{} : Vec3f{std::numeric_limits<float>::quiet_NaN(), 0, 1};
    const ReconstructResult r = faced(cloud);
    EXPECT_EQ(outward(r), 0.0);
    EXPECT_TRUE(r.unsure_normals.empty());
}

TEST(Facing, ContradictingNormalsAreNotBelieved) {
    const ReconstructResult r = faced(with_random_signs());
    EXPECT_EQ(outward(r), 1.0);
    EXPECT_EQ(r.unsure_normals.size() + r.report.num_unused, kPoints);
}

TEST(Facing, SensorsWinOverNormals) {
    PointCloud cloud = half_sphere(1.0);
    for (const Vec3d& p : cloud.positions)  // seen from within
        cloud.sensors.push_back(vec_cast<float>(normalized(Vec3d{0.1, 0.2, 0.0} - p)));
    EXPECT_EQ(outward(faced(cloud)), 0.0);
    for (std::size_t i = 0; i < cloud.size(); ++i)
        if (i % 3 != 0) cloud.sensors[i] = {};
    EXPECT_EQ(outward(faced(cloud)), 0.0);
    cloud.sensors.assign(cloud.size(), {});
    EXPECT_EQ(outward(faced(cloud)), 1.0);
}

TEST(Facing, AFewSensorsDoNotOutvoteTheNormals) {
    PointCloud cloud = half_sphere(1.0);
    cloud.sensors.assign(cloud.size(), {});
    cloud.sensors[kPoints / 3] = vec_cast<float>(normalized(-cloud.positions[kPoints / 3]));
    EXPECT_EQ(outward(faced(cloud)), 1.0);
}

TEST(Facing, MostSensorsDecide) {
    for (const int of_ten : {4, 6}) {
        PointCloud cloud = half_sphere(1.0);
        for (std::size_t i = 0; i < cloud.size(); ++i) {
            const Vec3d inward = normalized(-cloud.positions[i]);
            cloud.sensors.push_back(
                vec_cast<float>(static_cast<int>(hash64(i) % 10) < of_ten ? inward : -inward));
        }
        EXPECT_EQ(outward(faced(cloud)), of_ten > 5 ? 0.0 : 1.0);
    }
}

TEST(Facing, EachPieceHasItsOwn) {
    PointCloud cloud = half_sphere(1.0);
    for (std::size_t i = 0; i < kPoints; ++i)
        shapes::add_point(cloud, cloud.positions[i] + Vec3d{10, 0, 0},
                          -vec_cast<double>(cloud.normals[i]));
    const ReconstructResult r = faced(cloud);
    EXPECT_EQ(r.report.num_components, 2U);
    EXPECT_EQ(r.report.num_turned_pieces, 1U);
    const auto& p = r.surface.mesh.positions;
    for (const Triangle& t : r.surface.mesh.triangles) {
        const bool second = p[t[0]].x > 5.0;
        const Vec3d center = second ? Vec3d{10, 0, 0} : Vec3d{};
        const double side = dot(cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]), p[t[0]] - center);
        EXPECT_EQ(side > 0.0, !second);
    }
}

TEST(Facing, ClosedSurfacesFaceOutwardWhateverIsSaid) {
    PointCloud cloud = half_sphere(-1.0);
    cloud.sensors = cloud.normals;
    const ReconstructResult r = faced(cloud, Surface::kWatertight);
    EXPECT_GT(volume(r.surface.mesh.positions, r.surface.mesh.triangles), 0.0);
    EXPECT_EQ(r.report.num_turned_pieces, 0U);
}

}  // namespace
}  // namespace pointbake
