#include <stop_token>

#include "attributes/clouds.h"
#include "pointbake/attributes.h"

namespace pointbake {
namespace {

PointCloud estimated(const PointCloud& cloud) { return estimate_attributes(bare(cloud)).cloud; }

double mean_area(const PointCloud& cloud) {
    return sum_of_areas(cloud) / static_cast<double>(cloud.size());
}

TEST(EstimateAttributes, FindsThePlanesNormal) {
    const PointCloud plane = shapes::plane_cloud(30, 30, 0.1, 0.3);
    EXPECT_GT(worst_alignment(estimated(plane), plane), 1.0 - 1e-6);
}

TEST(EstimateAttributes, FindsNormalsOfCurvedSurfaces) {
    // By symmetry the covariance of an evenly sampled sphere is exact; unevenness tilts it by about
    // the neighbourhood's radius over the sphere's, squared.
    const PointCloud sphere = shapes::sphere_cloud(4000);
    EXPECT_GT(worst_alignment(estimated(sphere), sphere), 0.9998);  // 1.1 degrees
    const PointCloud torus = shapes::torus_cloud(8000);
    EXPECT_GT(worst_alignment(estimated(torus), torus), 0.998);  // 3.6 degrees
}

TEST(EstimateAttributes, TiltsUnderNoiseAsTheoryPredicts) {
    const double noise = 0.02, spacing = 0.1;
    const PointCloud plane = shapes::plane_cloud(60, 60, spacing, 0.3, noise);
    const PointCloud result = estimated(plane);
    double squares = 0.0;
    for (std::size_t i = 0; i < plane.size(); ++i) {
        const double cosine = alignment(result.normals[i], {0.0F, 1.0F, 0.0F});
        squares += 1.0 - cosine * cosine;
    }
    const double k = 16.0, radius = spacing * std::sqrt(k / 3.14159);
    const double predicted = 2.0 * std::sqrt(2.0) * noise / (radius * std::sqrt(k));
    const double rms = std::sqrt(squares / static_cast<double>(plane.size()));
    // The weights use fewer points than the formula counts, and borders are one-sided.
    EXPECT_GT(rms, 0.9 * predicted);
    EXPECT_LT(rms, 1.8 * predicted);
}

TEST(EstimateAttributes, AreasAreRightOnLatticesAndOnRandomPoints) {
    const auto inner_area = [](const PointCloud& plane, int side) {
        const auto middle = static_cast<std::size_t>(side * side / 2);
        return static_cast<double>(estimated(plane).areas[middle]);
    };
    EXPECT_NEAR(inner_area(shapes::plane_cloud(21, 21, 0.1), 21), 0.01, 0.0004);
    const PointCloud square = random_square(20000, 5);
    EXPECT_NEAR(mean_area(estimated(square)) * 20000.0, 1.0, 0.04);
    EXPECT_NEAR(sum_of_areas(estimated(shapes::sphere_cloud(5000))), 4.0 * 3.14159, 0.6);
}

TEST(EstimateAttributes, RadiusIsTheSpacingOfTheArea) {
    const AttributesResult result = estimate_attributes(bare(shapes::sphere_cloud(500)));
    for (std::size_t i = 0; i < result.cloud.size(); ++i)
        ASSERT_EQ(result.cloud.radii[i], std::sqrt(result.cloud.areas[i]));
    EXPECT_NEAR(result.report.median_spacing, std::sqrt(4.0 * 3.14159 / 500.0), 0.01);
    EXPECT_EQ(result.report.num_estimated_normals, 500U);
    EXPECT_EQ(result.report.num_invalid_normals, 0U);
}

TEST(EstimateAttributes, WidensTheNeighborhoodAcrossScanLines) {
    // Lines six times farther apart than the samples along them: 16 neighbours are one line.
    PointCloud scan;
    for (int line = 0; line < 20; ++line)
        for (int i = 0; i < 120; ++i)
            shapes::add_point(scan, {0.1 * i, 0.0, 0.6 * line}, {0.0, 1.0, 0.0});
    const AttributesResult result = estimate_attributes(bare(scan));
    EXPECT_EQ(result.report.num_invalid_normals, 0U);
    EXPECT_GT(worst_alignment(result.cloud, scan), 1.0 - 1e-6);
}

TEST(EstimateAttributes, CallsNormalsOfALineUnknown) {
    PointCloud line;
    for (int i = 0; i < 100; ++i) line.positions.push_back({0.1 * i, 0.2 * i, -0.3 * i});
    const AttributesResult result = estimate_attributes(line);
    EXPECT_EQ(result.report.num_invalid_normals, 100U);
    for (const Vec3f n : result.cloud.normals) EXPECT_EQ(n, Vec3f{});
}

TEST(EstimateAttributes, TakesFewPointsAndPointsInOnePlace) {
    for (const std::size_t count : {0U, 1U, 2U, 3U, 40U}) {
        PointCloud cloud;
        cloud.positions.assign(count, {1.0, 2.0, 3.0});
        const AttributesResult result = estimate_attributes(cloud);
        EXPECT_EQ(result.report.num_invalid_normals, count);
        EXPECT_EQ(result.cloud.normals.size(), count);
        EXPECT_EQ(result.cloud.areas, std::vector<float>(count, 0.0F));
        EXPECT_EQ(result.cloud.radii, std::vector<float>(count, 0.0F));
        EXPECT_EQ(result.report.median_spacing, 0.0);
    }
    PointCloud three;
    three.positions = {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}};
    const PointCloud result = estimate_attributes(three).cloud;
    for (const Vec3f n : result.normals) EXPECT_EQ(n, (Vec3f{0.0F, 0.0F, 1.0F}));
    for (const float a : result.areas) EXPECT_GT(a, 0.0F);
}

TEST(EstimateAttributes, KeepsWhatTheFileGives) {
    PointCloud cloud = shapes::sphere_cloud(300);
    cloud.radii.assign(300, 0.25F);
    cloud.radii[7] = 0.0F;
    cloud.normals[5] = {};
    cloud.normals[9] = {NAN, 0.0F, 1.0F};
    const AttributesResult result = estimate_attributes(cloud);
    EXPECT_EQ(result.report.num_estimated_normals, 2U);
    for (const std::size_t i : {5U, 9U}) {
        const Vec3f truth = vec_cast<float>(cloud.positions[i]);
        EXPECT_GT(alignment(result.cloud.normals[i], truth), 0.99);
    }
    EXPECT_EQ(result.cloud.normals[6], cloud.normals[6]);
    EXPECT_EQ(result.cloud.radii[6], 0.25F);
    EXPECT_EQ(result.cloud.radii[7], std::sqrt(result.cloud.areas[7]));
}

TEST(EstimateAttributes, DoesNotDependOnTheOrderOfThePoints) {
    const PointCloud torus = shapes::torus_cloud(2000, 1.0, 0.4, 0.01);
    const PointCloud straight = estimated(torus);
    const std::vector<Index> order = shuffled_order(torus.size(), 3);
    PointCloud shuffled;
    for (const Index i : order) shuffled.positions.push_back(torus.positions[i]);
    const PointCloud result = estimated(shuffled);
    for (std::size_t k = 0; k < order.size(); ++k) {
        ASSERT_EQ(result.normals[k], straight.normals[order[k]]);
        ASSERT_EQ(result.areas[k], straight.areas[order[k]]);
    }
}

TEST(EstimateAttributes, DoesNotDependOnThePlaceInSpace) {
    // Steps of 2^-10: moving them by a million loses no bit.
    PointCloud near = bare(shapes::torus_cloud(1000));
    for (Vec3d& p : near.positions)
        for (std::size_t k = 0; k < 3; ++k) p[k] = std::floor(p[k] * 1024.0) / 1024.0;
    PointCloud far = near;
    for (Vec3d& p : far.positions) p += Vec3d{500000.0, 5000000.0, 300.0};
    expect_same_attributes(estimated(near), estimated(far));
}

TEST(EstimateAttributes, DoesNotDependOnTheUnit) {
    const PointCloud torus = shapes::torus_cloud(1000);
    PointCloud tiny = bare(torus);
    for (Vec3d& p : tiny.positions) p = p * 0x1.0p-40;
    EXPECT_EQ(estimated(tiny).normals, estimated(torus).normals);
}

TEST(EstimateAttributes, GivesTheSameBytesForAnyNumberOfThreads) {
    const PointCloud cloud = bare(shapes::torus_cloud(5000, 1.0, 0.4, 0.02));
    const PointCloud one = estimate_attributes(cloud, {}, {.threads = 1}).cloud;
    expect_same_attributes(one, estimate_attributes(cloud, {}, {.threads = 7}).cloud);
}

TEST(EstimateAttributes, StopsWhenTold) {
    std::stop_source stop;
    stop.request_stop();
    expect_error(ErrorCode::kCancelled, [&] {
        estimate_attributes(bare(shapes::sphere_cloud(100)), {}, {.stop = stop.get_token()});
    });
}

TEST(EstimateAttributes, RefusesTooFewNeighbors) {
    expect_error(ErrorCode::kInvalidOption,
                 [] { estimate_attributes(shapes::sphere_cloud(100), {.neighbors = 2}); });
}

TEST(SpacingStats, MeasuresTheDistanceToTheNearestNeighbor) {
    const SpacingStats grid = spacing_stats(shapes::plane_cloud(20, 20, 0.5));
    EXPECT_NEAR(grid.median, 0.5, 1e-6);
    EXPECT_NEAR(grid.p5, 0.5, 1e-6);
    EXPECT_NEAR(grid.p95, 0.5, 1e-6);
    // Random points of density n: P(distance > d) = exp(-pi n d^2).
    const SpacingStats random = spacing_stats(random_square(5000, 8));
    const double unit = 1.0 / std::sqrt(3.14159 * 5000.0);
    EXPECT_NEAR(random.median, unit * 0.8326, 0.05 * unit);
    EXPECT_NEAR(random.p5, unit * 0.2265, 0.05 * unit);
    EXPECT_NEAR(random.p95, unit * 1.7308, 0.1 * unit);
    EXPECT_EQ(spacing_stats(random_square(1, 8)).median, 0.0);
}

}  // namespace
}  // namespace pointbake
