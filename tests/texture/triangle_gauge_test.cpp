#include "texture/triangle_gauge.h"

#include <gtest/gtest.h>

#include "core/adjacency.h"
#include "texture/level_errors.h"
#include "texture/planes.h"

namespace pointbake {
namespace {

/// What the gauge of a triangle paints, with its colours as they are.
struct Scene {
    Painted painted;
    std::vector<std::array<Index, 3>> neighbors = triangle_neighbors(painted.mesh.triangles);
    Shell shell{painted.mesh, Projection::kInterpolated, {}};
    Kernel kernel{};
    Footprints prints =
        project_points(painted.mesh, painted.cloud, painted.owners, shell, neighbors, kernel, {});
    std::vector<Vec3f> values = colors();

    SplatScene splats() const { return {painted.mesh, shell, neighbors, prints, kernel}; }
    MapValues map() const { return {MapKind::kColor, values, {}, values}; }
    std::vector<Vec3f> colors() const {
        std::vector<Vec3f> out;
        for (const Footprint& f : prints.items)
            out.push_back(color_value(painted.cloud.colors[f.point]));
        return out;
    }
};

TEST(TriangleGauge, BothSidesSeeTheSameWhereNoSplatReaches) {
    // A gap of some spacings along the diagonal, wider on one side: the nearest splats tell, and
    // those of one side do not reach the other triangle by themselves.
    Painted p = painted_square(60, [](double x, double y) {
        return Vec3d{x < 0.5 ? 0.2 : 0.8, y < 0.3 ? 0.1 : 0.9, 0.5};
    });
    for (std::size_t i = 0; i < p.owners.size(); ++i) {
        const Vec3d x = p.cloud.positions[i];
        if (x.x - x.y > -0.1 && x.x - x.y < 0.05) p.owners[i] = kInvalidIndex;
    }
    const Scene scene{p};
    std::array<PatchTexels, 2> sides;
    for (Index t = 0; t < 2; ++t) {
        TriangleGauge gauge(scene.splats(), scene.painted.cloud, scene.map());
        gauge.look_at(t);
        gauge.gather();
        sides[t] = gauge.texels(patch_layout(scene.shell.frame(t), 60.0));
    }
    for (double s = 0.1; s < 0.95; s += 0.1) {
        std::array<Vec3f, 2> seen;
        for (Index t = 0; t < 2; ++t) {
            const auto& c = scene.shell.frame(t).corners;  // the diagonal: 0 to 2, and 0 to 1
            const Vec2d place = c[0] + (c[t == 0 ? 2 : 1] - c[0]) * s;
            seen[t] = sample_bilinear(sides[t], MapKind::kColor,
                                      sides[t].layout.texel_of(vec_cast<float>(place)));
        }
        EXPECT_LT(255.0F * length(seen[0] - seen[1]), 6.0F) << "at " << s;
    }
}

TEST(TriangleGauge, AKnownWidthGathersTheSame) {
    Painted p = painted_square(60, wave);
    for (std::size_t i = 0; i < p.owners.size(); ++i) {
        const Vec3d x = p.cloud.positions[i];
        if (std::abs(x.x - x.y) < 0.08) p.owners[i] = kInvalidIndex;
    }
    Scene scene{p};
    const auto painted = [&] {
        TriangleGauge gauge(scene.splats(), scene.painted.cloud, scene.map());
        gauge.look_at(0);
        gauge.gather();
        EXPECT_GT(gauge.widen(), 1.0F);
        return std::pair(gauge.texels(patch_layout(scene.shell.frame(0), 40.0)).coded,
                         gauge.widen());
    };
    const auto [found, width] = painted();
    scene.prints.widen = {width, width};
    EXPECT_EQ(painted().first, found);
}

TEST(LevelErrors, ATriangleWithoutPointsMayBeAsFineAsItsBorder) {
    // Stripes that cross the diagonal, all points on one side of it.
    Painted p = painted_square(60, [](double x, double y) {
        return static_cast<int>(10.0 * (x + y)) % 2 == 0 ? Vec3d{0.9, 0.9, 0.9} : Vec3d{};
    });
    for (Index& owner : p.owners)
        if (owner == 1) owner = kInvalidIndex;
    const Scene scene{p};
    const auto finest = [&](AtlasKind atlas) {
        TextureOptions options;
        options.atlas = atlas;
        const LevelErrors levels =
            measure_levels(scene.splats(), scene.painted.cloud, scene.map(), options, {});
        return levels.needed(1, static_cast<std::uint8_t>(levels.patches[1].count - 1));
    };
    EXPECT_GT(finest(AtlasKind::kTriangles), 300);
    // In a chart the texels beside it are its own.
    EXPECT_LT(finest(AtlasKind::kCharts), 40);
}

}  // namespace
}  // namespace pointbake
