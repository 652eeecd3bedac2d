// The surface around Gaussian splats.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stop_token>

#include "core/adjacency.h"
#include "pointbake/error.h"
#include "pointbake/splats.h"
#include "reconstruct/splat_grid.h"
#include "support/shapes.h"

namespace pointbake {
namespace {

constexpr Rgb16 kRed{65535, 0, 0}, kGreen{0, 65535, 0}, kWhite{65535, 65535, 65535};

void append(PointCloud& cloud, const PointCloud& more) {
    for (std::size_t i = 0; i < more.size(); ++i) {
        shapes::add_point(cloud, more.positions[i], vec_cast<double>(more.normals[i]));
        cloud.axes.push_back(more.axes[i]);
        cloud.weights.push_back(more.weights[i]);
        cloud.colors.push_back(more.colors[i]);
    }
}

/// A sphere's splats overlap: sigma is 0.7 of their spacing.
PointCloud splat_sphere(std::uint64_t n, double radius = 1.0, Rgb16 color = kRed,
                        float opacity = 0.9F) {
    PointCloud cloud = shapes::sphere_cloud(n, 0.0, radius);
    const double spacing = radius * std::sqrt(4.0 * std::numbers::pi / static_cast<double>(n));
    shapes::make_splats(cloud, static_cast<float>(0.7 * spacing), opacity);
    cloud.colors.assign(cloud.size(), color);
    return cloud;
}

PointCloud one_of(const PointCloud& cloud, std::size_t i) {
    PointCloud one;
    shapes::add_point(one, cloud.positions[i], vec_cast<double>(cloud.normals[i]));
    one.axes = {cloud.axes[i]};
    one.weights = {cloud.weights[i]};
    one.colors = {cloud.colors[i]};
    return one;
}

double area_of(const PointCloud& cloud) {
    double sum = 0.0;
    for (const float a : cloud.areas) sum += static_cast<double>(a);
    return sum;
}

/// Nearest and farthest from the origin.
std::pair<double, double> radii_of(const SplatSurface& found) {
    double least = HUGE_VAL, most = 0.0;
    for (const Vec3d& p : found.mesh.positions) {
        least = std::min(least, length(p));
        most = std::max(most, length(p));
    }
    return {least, most};
}

TEST(SplatSurface, OfASphereIsTheSphere) {
    const SplatSurface found = splat_surface(splat_sphere(4000), {});
    const Topology t = topology(found.mesh.positions.size(), found.mesh.triangles);
    EXPECT_TRUE(t.is_closed_manifold());
    EXPECT_EQ(t.num_components, 1U);
    EXPECT_EQ(t.euler(), 2);
    // Half opaque outlines lie before the middle of the splats.
    const auto [least, most] = radii_of(found);
    EXPECT_GT(least, 1.0);
    EXPECT_LT(most, 1.0 + 0.65 * found.step);
    EXPECT_LT(most - least, 0.35 * found.step);
    EXPECT_GT(volume(found.mesh.positions, found.mesh.triangles), 0.0);
    const double radius = 0.5 * (least + most);
    EXPECT_NEAR(area_of(found.cloud), 4.0 * std::numbers::pi * radius * radius, 0.2);
}

TEST(SplatSurface, HasAPointPerVertexWithNormalColourAndRow) {
    const PointCloud splats = splat_sphere(2000);
    const SplatSurface found = splat_surface(splats, {});
    ASSERT_EQ(found.cloud.size(), found.mesh.positions.size());
    EXPECT_EQ(found.cloud.num_rows, splats.num_rows);
    for (std::size_t i = 0; i < found.cloud.size(); ++i) {
        const Vec3d p = found.cloud.positions[i];
        EXPECT_EQ(p, found.mesh.positions[i]);
        EXPECT_GT(dot(vec_cast<double>(found.cloud.normals[i]), p / length(p)), 0.8);
        EXPECT_EQ(found.cloud.colors[i], kRed);
        // The splat that shows most there is near.
        EXPECT_LT(length(splats.positions[found.cloud.rows[i]] - p), 3.0 * found.step);
    }
}

TEST(SplatSurface, ShowsWhatIsInFront) {
    PointCloud splats = splat_sphere(4000);
    append(splats, splat_sphere(4000, 0.95, kGreen));
    const SplatSurface found = splat_surface(splats, {});
    EXPECT_EQ(topology(found.mesh.positions.size(), found.mesh.triangles).num_components, 1U);
    for (const Rgb16& c : found.cloud.colors) EXPECT_GT(c.r, 5 * c.g);
}

TEST(SplatSurface, MixesWhatShowsThrough) {
    // Each of the front sheet stops little; four overlap.
    PointCloud splats = splat_sphere(4000, 1.0, kRed, 0.12F);
    append(splats, splat_sphere(4000, 0.98, kGreen, 0.95F));
    const SplatSurface found = splat_surface(splats, {});
    for (const Rgb16& c : found.cloud.colors) {
        EXPECT_GT(c.r, 10000);
        EXPECT_GT(c.g, 20000);
    }
}

TEST(SplatSurface, IsNotEnteredThroughSmallGaps) {
    // Splats reach into the gap that a cap leaves: of one six steps wide some three stay open, and
    // that is closed. Through a wide one the inside is outside, too: the shell has two sides.
    const auto area_without = [](double width) {
        const PointCloud whole = splat_sphere(4000);
        PointCloud splats;
        for (std::size_t i = 0; i < whole.size(); ++i) {
            if (length(whole.positions[i] - Vec3d{0, 1, 0}) < 0.5 * width) continue;
            append(splats, one_of(whole, i));
        }
        return area_of(splat_surface(splats, {}).cloud);
    };
    const double step = splat_surface(splat_sphere(4000), {}).step;
    EXPECT_LT(area_without(6.0 * step), 1.2 * 4.0 * std::numbers::pi);
    EXPECT_GT(area_without(14.0 * step), 1.6 * 4.0 * std::numbers::pi);
}

TEST(SplatSurface, GapsAreColouredAsAround) {
    PointCloud whole = splat_sphere(4000);
    const double step = splat_surface(whole, {}).step;
    PointCloud splats;
    for (std::size_t i = 0; i < whole.size(); ++i)
        if (length(whole.positions[i] - Vec3d{0, 1, 0}) > 3.0 * step)
            append(splats, one_of(whole, i));
    for (const Rgb16& c : splat_surface(splats, {}).cloud.colors) EXPECT_EQ(c, kRed);
}

TEST(SplatSurface, DropsCrumbs) {
    PointCloud splats = splat_sphere(20000);
    PointCloud crumb;
    shapes::add_point(crumb, {3, 0, 0}, {1, 0, 0});
    crumb.axes = {splats.axes[0]};
    crumb.weights = {0.9F};
    crumb.colors = {kGreen};
    append(splats, crumb);
    const SplatSurface found = splat_surface(splats, {});
    EXPECT_EQ(topology(found.mesh.positions.size(), found.mesh.triangles).num_components, 1U);
}

TEST(SplatSurface, IsTheSameForAnyNumberOfThreads) {
    const PointCloud splats = splat_sphere(3000);
    Context one, four;
    one.threads = 1;
    four.threads = 4;
    const SplatSurface a = splat_surface(splats, one), b = splat_surface(splats, four);
    EXPECT_EQ(a.mesh.positions, b.mesh.positions);
    EXPECT_EQ(a.mesh.triangles, b.mesh.triangles);
    EXPECT_EQ(a.cloud.colors, b.cloud.colors);
    EXPECT_EQ(a.cloud.rows, b.cloud.rows);
    EXPECT_EQ(a.cloud.normals, b.cloud.normals);
    EXPECT_EQ(a.cloud.areas, b.cloud.areas);
}

TEST(SplatSurface, OfOneSplatIsABlob) {
    PointCloud splats = splat_sphere(1);
    const SplatSurface found = splat_surface(splats, {});
    EXPECT_TRUE(topology(found.mesh.positions.size(), found.mesh.triangles).is_closed_manifold());
}

TEST(SplatSurface, NothingOpaqueIsRefused) {
    const auto code_of = [](const PointCloud& splats) {
        try {
            splat_surface(splats, {});
        } catch (const Error& error) {
            return error.code();
        }
        return ErrorCode::kCancelled;
    };
    EXPECT_EQ(code_of(splat_sphere(50, 1.0, kRed, 0.05F)), ErrorCode::kDegenerate);
    PointCloud flat = splat_sphere(50);
    flat.axes.assign(flat.size(), {});
    EXPECT_EQ(code_of(flat), ErrorCode::kDegenerate);
}

TEST(SplatSurface, OfScatteredSplatsIsCoarseInsteadOfHuge) {
    PointCloud splats = splat_sphere(500);
    append(splats, splat_sphere(500));
    for (std::size_t i = 500; i < 1000; ++i)
        splats.positions[i] = splats.positions[i] * 0.1 + Vec3d{1e6, 1e6, 1e6};
    for (TangentAxes& a : splats.axes) a = {a.u * 1e-3F, a.v * 1e-3F};
    const SplatSurface found = splat_surface(splats, {});
    EXPECT_GT(found.step, 100.0);
    EXPECT_GT(found.step, 1000.0 * found.wanted_step);
    // Nothing is thick enough to be met by a line there.
    for (const Rgb16& c : found.cloud.colors) EXPECT_EQ(c, kRed);
}

TEST(SplatSurface, LooksThroughToWhatIsSomeStepsBehind) {
    // Wherever the lattice lies: with parts of its bricks' side as a shift.
    const double step = splat_surface(splat_sphere(4000), {}).step;
    for (int shift = 0; shift < 8; ++shift) {
        PointCloud splats = splat_sphere(4000, 1.0, kRed, 0.2F);
        append(splats, splat_sphere(4000, 1.0 - 3.0 * step, kGreen, 0.95F));
        for (Vec3d& p : splats.positions) p += Vec3d{shift * step, 0.0, 0.0};
        append(splats, one_of(splats, 0));  // keeps the lattice where it is
        splats.positions.back() = {-4.0, -4.0, -4.0};
        std::size_t num_red = 0;
        const SplatSurface found = splat_surface(splats, {});
        for (const Rgb16& c : found.cloud.colors) num_red += c.g < 6000;
        EXPECT_LT(num_red, found.cloud.size() / 20) << shift;
    }
}

TEST(SplatSurface, ManyDegreesOfWhiteAreWhite) {
    for (const float opacity : {0.11F, 0.3F, 0.7F, 0.99F}) {
        const SplatSurface found = splat_surface(splat_sphere(3000, 1.0, kWhite, opacity), {});
        for (const Rgb16& c : found.cloud.colors)
            EXPECT_GT(std::min({c.r, c.g, c.b}), 65500) << opacity;
    }
}

TEST(SplatSurface, FarFromTheOriginIsAsFineAsCoordinatesAre) {
    PointCloud splats = splat_sphere(1);
    splats.positions[0] = {1e15, 1e15, 1e15};
    splats.axes[0] = {{0.011F, 0.011F, 0.011F}, {0.0007F, -0.0007F, 0.0F}};
    const SplatSurface found = splat_surface(splats, {});
    EXPECT_GT(found.step, 100.0);
    EXPECT_TRUE(topology(found.mesh.positions.size(), found.mesh.triangles).is_closed_manifold());
}

TEST(SplatSurface, TinyAndHugeOnesAreTheSame) {
    const auto num_triangles = [](double size) {
        PointCloud splats = splat_sphere(500);
        for (Vec3d& p : splats.positions) p = p * size;
        const auto scale = static_cast<float>(size);
        for (TangentAxes& a : splats.axes) a = {a.u * scale, a.v * scale};
        return splat_surface(splats, {}).mesh.triangles.size();
    };
    EXPECT_EQ(num_triangles(std::ldexp(1.0, -40)), num_triangles(1.0));
    EXPECT_EQ(num_triangles(std::ldexp(1.0, 40)), num_triangles(1.0));
}

TEST(SplatSurface, StopsWhenCancelled) {
    std::stop_source stop;
    stop.request_stop();
    Context context;
    context.stop = stop.get_token();
    EXPECT_THROW(splat_surface(splat_sphere(100), context), Error);
}

TEST(SplatSurface, SplatsWithoutANormalAreAsThickAsWide) {
    PointCloud cloud = splat_sphere(1);
    const Splat flat = splat_of(cloud, 0);
    EXPECT_FLOAT_EQ(flat.sigmas[2], 0.1F * flat.sigmas[1]);
    EXPECT_NEAR(std::abs(dot(flat.axes[2], cloud.normals[0])), 1.0, 1e-6);
    cloud.normals[0] = {};
    const Splat blob = splat_of(cloud, 0);
    EXPECT_FLOAT_EQ(blob.sigmas[2], blob.sigmas[1]);
}

TEST(SplatGrid, FindsEveryCubeWithBothSigns) {
    for (int part = 0; part < 8; ++part) {
        const double shift = 0.05 * part;  // of a brick's side
        PointCloud cloud = splat_sphere(4000);
        std::vector<Splat> splats;
        for (std::size_t i = 0; i < cloud.size(); ++i) splats.push_back(splat_of(cloud, i));
        // Moves the lattice.
        splats.push_back(splats[0]);
        splats.back().center = {-1.5 - shift, -1.5 - shift, -1.5 - shift};
        const SplatGrid grid(splats, 0.05, {});
        std::vector<SplatGrid::Point> wanted;
        const SplatGrid::Point size = grid.size();
        SplatGrid::Point p{};
        for (p[2] = 0; p[2] + 1 < size[2]; ++p[2])
            for (p[1] = 0; p[1] + 1 < size[1]; ++p[1])
                for (p[0] = 0; p[0] + 1 < size[0]; ++p[0]) {
                    int num_inside = 0;
                    for (int c = 0; c < 8; ++c)
                        num_inside +=
                            grid.value({p[0] + (c & 1), p[1] + (c >> 1 & 1), p[2] + (c >> 2)}) < 0;
                    if (num_inside > 0 && num_inside < 8) wanted.push_back(p);
                }
        std::vector<SplatGrid::Point> found = grid.mixed_cubes({});
        std::ranges::sort(found);
        std::ranges::sort(wanted);
        EXPECT_EQ(found, wanted) << shift;
    }
}

TEST(SplatGrid, IsBelowZeroInsideAndAboveOutside) {
    const PointCloud cloud = splat_sphere(4000);
    std::vector<Splat> splats;
    for (std::size_t i = 0; i < cloud.size(); ++i) splats.push_back(splat_of(cloud, i));
    const SplatGrid grid(splats, 0.05, {});
    const SplatGrid::Point size = grid.size();
    for (std::int32_t z = 0; z < size[2]; ++z)
        for (std::int32_t y = 0; y < size[1]; ++y)
            for (std::int32_t x = 0; x < size[0]; ++x) {
                const double r = length(grid.place(
                    {static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)}));
                if (std::abs(r - 1.0) < 2.0 * grid.step()) continue;
                ASSERT_EQ(grid.value({x, y, z}) < 0.0F, r < 1.0) << r;
            }
}

}  // namespace
}  // namespace pointbake
