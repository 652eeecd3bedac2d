// What the stage does in builds without CGAL (-DPOINTBAKE_CGAL=OFF).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/adjacency.h"
#include "pointbake/error.h"
#include "pointbake/reconstruct.h"
#include "support/shapes.h"

namespace pointbake {
namespace {

/// Points with the normals and areas that the implicit method works from.
PointCloud with_areas(PointCloud cloud, double area) {
    cloud.areas.assign(cloud.size(), static_cast<float>(area / static_cast<double>(cloud.size())));
    return cloud;
}

PointCloud sphere() { return with_areas(shapes::sphere_cloud(2000), 4.0 * std::numbers::pi); }

PointCloud half_sphere() {
    return with_areas(shapes::half_sphere_cloud(2000), 2.0 * std::numbers::pi);
}

TEST(WithoutCgal, TheCoconeFamilyIsRefused) {
    for (const Method method : {Method::kCocone, Method::kTightCocone, Method::kRobustCocone}) {
        EXPECT_FALSE(is_available(method));
        try {
            reconstruct(sphere(), {.method = method});
            FAIL() << to_word(method);
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ErrorCode::kInvalidOption);
            EXPECT_THAT(error.what(), testing::HasSubstr(to_word(method)));
            EXPECT_THAT(error.what(), testing::HasSubstr("CGAL"));
        }
    }
}

TEST(WithoutCgal, AutoIsTheImplicitMethod) {
    EXPECT_TRUE(is_available(Method::kAuto));
    EXPECT_TRUE(needs_normals({}));
    const ReconstructResult automatic = reconstruct(sphere());
    EXPECT_EQ(automatic.report.method, Method::kImplicit);
    const ReconstructResult asked = reconstruct(sphere(), {.method = Method::kImplicit});
    EXPECT_EQ(automatic.surface.mesh.positions, asked.surface.mesh.positions);
    EXPECT_EQ(automatic.surface.mesh.triangles, asked.surface.mesh.triangles);
}

TEST(WithoutCgal, EverySurfaceIsThere) {
    for (const Surface wanted : {Surface::kAuto, Surface::kOpen, Surface::kWatertight}) {
        const ReconstructReport whole = reconstruct(sphere(), {.surface = wanted}).report;
        EXPECT_EQ(whole.num_boundary_loops, 0U) << to_word(wanted);
        EXPECT_EQ(whole.num_components, 1U) << to_word(wanted);
        const ReconstructReport half = reconstruct(half_sphere(), {.surface = wanted}).report;
        const bool is_closed = wanted == Surface::kWatertight;
        EXPECT_EQ(half.num_boundary_loops, is_closed ? 0U : 1U) << to_word(wanted);
        EXPECT_EQ(half.surface, is_closed ? Surface::kWatertight : Surface::kOpen);
    }
}

}  // namespace
}  // namespace pointbake
