#include "pointbake/denoise.h"

#include <cmath>
#include <functional>
#include <stop_token>

#include "attributes/clouds.h"

namespace pointbake {
namespace {

constexpr std::uint64_t kCount = 20000;

/// Side of the square that each point of an area has.
double spacing_on(double area, std::uint64_t count) {
    return std::sqrt(area / static_cast<double>(count));
}
const double kSphereSpacing = spacing_on(4.0 * std::numbers::pi, kCount);

/// Moved every way, like the noise of a scanner with poor registration.
PointCloud with_noise(PointCloud cloud, double deviation, std::uint64_t seed = 7) {
    for (std::size_t i = 0; i < cloud.size(); ++i)
        cloud.positions[i] +=
            Vec3d{shapes::random_normal(seed, 3 * i), shapes::random_normal(seed, 3 * i + 1),
                  shapes::random_normal(seed, 3 * i + 2)} *
            deviation;
    return cloud;
}

PointCloud noisy_sphere(double noise) {
    return with_noise(bare(shapes::sphere_cloud(kCount)), noise * kSphereSpacing);
}

using Distance = std::function<double(Vec3d)>;
double rms(const PointCloud& cloud, const Distance& distance) {
    double sum = 0.0;
    for (const Vec3d p : cloud.positions) sum += distance(p) * distance(p);
    return std::sqrt(sum / static_cast<double>(cloud.size()));
}
double to_unit_sphere(Vec3d p) { return length(p) - 1.0; }
/// The surface of the cube from -1 to 1.
double to_cube(Vec3d p) {
    const Vec3d a{std::fabs(p.x) - 1.0, std::fabs(p.y) - 1.0, std::fabs(p.z) - 1.0};
    const double inside = std::min(std::max({a.x, a.y, a.z}), 0.0);
    const Vec3d out{std::max(a.x, 0.0), std::max(a.y, 0.0), std::max(a.z, 0.0)};
    return inside + length(out);
}

TEST(MeasureNoise, ReadsGaussianNoise) {
    EXPECT_LT(measure_noise(noisy_sphere(0.0)), 0.01);
    EXPECT_NEAR(measure_noise(noisy_sphere(0.05)), 0.05, 0.005);
    EXPECT_NEAR(measure_noise(noisy_sphere(0.1)), 0.1, 0.01);
    EXPECT_NEAR(measure_noise(noisy_sphere(0.3)), 0.3, 0.03);
    // As thick as this the layer is cut by the ball of the neighbours.
    EXPECT_NEAR(measure_noise(noisy_sphere(1.0)), 0.85, 0.15);
}

TEST(MeasureNoise, DoesNotTakeAnotherWallForNoise) {
    PointCloud walls = random_square(5000, 3);
    for (const Vec3d p : random_square(5000, 4).positions)
        walls.positions.push_back(p + Vec3d{0.0, 0.0, 1.8 * spacing_on(1.0, 5000)});
    EXPECT_LT(measure_noise(walls), 0.02);
}

TEST(MeasureNoise, OfOneWallIsNotTheDistanceToTheOther) {
    const double spacing = spacing_on(1.0, 5000);
    for (const auto& [gap, noise] : {std::pair{2.7, 0.2}, {2.7, 0.3}, {3.0, 0.3}}) {
        PointCloud walls;
        for (const std::uint64_t wall : {0U, 1U})
            for (const Vec3d p : random_square(5000, 3 + wall).positions) {
                const std::uint64_t i = walls.positions.size();
                const Vec3d off{shapes::random_normal(5, i), shapes::random_normal(6, i),
                                shapes::random_normal(7, i)};
                walls.positions.push_back(p + off * (noise * spacing) +
                                          Vec3d{0.0, 0.0, gap * spacing * double(wall)});
            }
        EXPECT_NEAR(measure_noise(walls), noise, 0.15 * noise) << gap;
    }
}

TEST(MeasureNoise, IsZeroForAHandfulOfPoints) {
    EXPECT_EQ(measure_noise(bare(shapes::sphere_cloud(63))), 0.0);
}

TEST(Denoise, MovesPointsOntoTheSphere) {
    for (const auto& [noise, left] : {std::pair{0.1, 0.4}, {0.3, 0.3}, {1.0, 0.25}}) {
        const PointCloud cloud = noisy_sphere(noise);
        const DenoiseResult done = denoise(cloud);
        EXPECT_TRUE(done.report.is_done);
        EXPECT_LT(rms(done.cloud, to_unit_sphere), left * rms(cloud, to_unit_sphere)) << noise;
        EXPECT_LT(done.report.noise_left, 0.3 * noise) << noise;
    }
}

TEST(Denoise, DoesNotRoundOffCreases) {
    const double spacing = spacing_on(24.0, 6 * 60 * 60);
    const PointCloud cloud = with_noise(bare(shapes::cube_cloud(60)), 0.1 * spacing);
    const DenoiseResult done = denoise(cloud);
    ASSERT_TRUE(done.report.is_done);
    double farthest = 0.0;
    for (const Vec3d p : done.cloud.positions) farthest = std::max(farthest, std::fabs(to_cube(p)));
    EXPECT_LT(rms(done.cloud, to_cube), 0.75 * rms(cloud, to_cube));
    EXPECT_LT(farthest, 0.6 * spacing);  // an edge rounded over two spacings is that far off
}

TEST(Denoise, KeepsTwoWallsApart) {
    const double spacing = spacing_on(1.0, 5000), gap = 4.0 * spacing;
    PointCloud walls = random_square(5000, 3);
    for (const Vec3d p : random_square(5000, 4).positions)
        walls.positions.push_back(p + Vec3d{0.0, 0.0, gap});
    const PointCloud cloud = with_noise(walls, 0.3 * spacing);
    const auto to_walls = [&](Vec3d p) { return std::min(std::fabs(p.z), std::fabs(p.z - gap)); };
    const DenoiseResult done = denoise(cloud);
    ASSERT_TRUE(done.report.is_done);
    EXPECT_LT(rms(done.cloud, to_walls), 0.7 * rms(cloud, to_walls));
}

TEST(Denoise, LeavesCleanCloudsAlone) {
    const PointCloud cloud = noisy_sphere(0.03);
    const DenoiseResult done = denoise(cloud);
    EXPECT_FALSE(done.report.is_done);
    EXPECT_NEAR(done.report.noise, 0.03, 0.005);
    EXPECT_EQ(done.cloud.positions, cloud.positions);
    EXPECT_TRUE(done.cloud.measured.empty());
}

TEST(Denoise, CanBeTurnedOnAndOff) {
    EXPECT_TRUE(denoise(noisy_sphere(0.03), {Denoise::kOn}).report.is_done);
    const PointCloud cloud = noisy_sphere(0.3);
    const DenoiseResult off = denoise(cloud, {Denoise::kOff});
    EXPECT_EQ(off.cloud.positions, cloud.positions);
    EXPECT_NEAR(off.report.noise, 0.3, 0.03);  // told
    EXPECT_EQ(off.cloud.noise, 0.0);           // and without effect
    EXPECT_FALSE(denoise(bare(shapes::sphere_cloud(63))).report.is_measured);
}

TEST(Denoise, LeavesWhatDoesNotGoAway) {
    // Points anywhere in a ball: no surface to move them onto.
    PointCloud cloud;
    for (std::uint64_t i = 0; cloud.size() < kCount; i += 3) {
        const Vec3d p{shapes::random_normal(3, i), shapes::random_normal(3, i + 1),
                      shapes::random_normal(3, i + 2)};
        cloud.positions.push_back(p);
    }
    const DenoiseResult done = denoise(cloud);
    EXPECT_TRUE(done.report.is_relief);
    EXPECT_FALSE(done.report.is_done);
    EXPECT_EQ(done.cloud.positions, cloud.positions);
    EXPECT_TRUE(done.cloud.measured.empty());
    EXPECT_EQ(done.cloud.noise, 0.0);
    EXPECT_TRUE(denoise(cloud, {Denoise::kOn}).report.is_done);
}

TEST(Denoise, KeepsWhatWasReadAndTellsTheShift) {
    const PointCloud cloud = noisy_sphere(0.3);
    const DenoiseResult done = denoise(cloud);
    EXPECT_EQ(done.cloud.measured, cloud.positions);
    double sum = 0.0, most = 0.0;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
        const double d = length(done.cloud.positions[i] - cloud.positions[i]);
        sum += d * d;
        most = std::max(most, d);
    }
    EXPECT_NEAR(done.report.shift_rms, std::sqrt(sum / static_cast<double>(cloud.size())), 1e-12);
    EXPECT_NEAR(done.report.shift_max, most, 1e-12);
}

TEST(Denoise, LeavesPointsFarOffWhereTheyAre) {
    PointCloud cloud = noisy_sphere(0.1);
    cloud.positions.push_back({0.0, 1.0 + 2.5 * kSphereSpacing, 0.0});
    const DenoiseResult done = denoise(cloud);
    EXPECT_EQ(done.cloud.positions.back(), cloud.positions.back());
}

TEST(Denoise, IsTheSameForAnyOrderAndNumberOfThreads) {
    const PointCloud cloud = noisy_sphere(0.3);
    const DenoiseResult one = denoise(cloud, {}, {.threads = 1});
    EXPECT_EQ(denoise(cloud, {}, {.threads = 3}).cloud.positions, one.cloud.positions);
    const std::vector<Index> order = shuffled_order(cloud.size(), 5);
    PointCloud shuffled;
    for (const Index i : order) shuffled.positions.push_back(cloud.positions[i]);
    const PointCloud again = denoise(shuffled).cloud;
    for (std::size_t i = 0; i < order.size(); ++i)
        ASSERT_EQ(again.positions[i], one.cloud.positions[order[i]]);
}

TEST(Denoise, CanBeCancelled) {
    std::stop_source source;
    source.request_stop();
    Context context;
    context.stop = source.get_token();
    EXPECT_THROW(denoise(noisy_sphere(0.3), {}, context), Error);
}

}  // namespace
}  // namespace pointbake
