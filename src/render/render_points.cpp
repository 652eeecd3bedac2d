// Points: opaque discs, tilted as their normals say.
#include <algorithm>
#include <cmath>

#include "core/color.h"
#include "core/kdtree.h"
#include "core/parallel.h"
#include "render/canvas.h"

namespace pointbake {
namespace {

using render::Band;
using render::Camera;
using render::RowRange;

// Clouds without radii: half the distance to the sixth neighbour (a whole ring of them on a
// surface) times this covers a surface without holes.
constexpr double kCoverage = 1.25;
constexpr std::size_t kRing = 6;
// A disc seen from the side keeps this share of its depth slope, lest it reach out in depth.
constexpr double kMinFacing = 0.15;
constexpr double kMinRadius = 0.3;  // pixels: no point falls between the samples

std::vector<float> radii_of(const PointCloud& cloud, const Context& context) {
    if (!cloud.radii.empty()) return cloud.radii;
    std::vector<float> radii(cloud.size());
    const KdTree tree(cloud.positions);
    constexpr std::size_t kGrain = 2048;
    parallel_for(context, cloud.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        std::array<Neighbor, kRing + 1> buffer;
        for (std::size_t p = begin; p < end; ++p) {
            const auto ring = tree.nearest(cloud.positions[p], buffer);
            radii[p] =
                static_cast<float>(0.5 * kCoverage * std::sqrt(ring.back().squared_distance));
        }
    });
    return radii;
}

// A disc on the picture.
struct Disc {
    Vec3d center;
    Vec3d normal;  // in picture axes (x right, y down, z towards the viewer); z > 0
    double radius = 0.0;
};

// Samples within the disc's outline; depth follows its plane.
void rasterize_disc(const Disc& d, Index id, Band& band) {
    const auto [first, last] = band.rows_between(d.center.y - d.radius, d.center.y + d.radius);
    const auto [begin, end] = band.columns_between(d.center.x - d.radius, d.center.x + d.radius);
    for (int row = first; row < last; ++row)
        for (int column = begin; column < end; ++column) {
            const double x = band.sample_x(column) - d.center.x;
            const double y = band.sample_y(row) - d.center.y;
            const double z = -(d.normal.x * x + d.normal.y * y) / d.normal.z;
            if (x * x + y * y + z * z <= d.radius * d.radius)
                band.offer(row, column, static_cast<float>(d.center.z + z), id);
        }
}

// Normal in picture axes, turned to the viewer; straight at the viewer if unknown.
Vec3d facing_normal(Vec3f normal, const Camera& camera) {
    const auto n = vec_cast<double>(normal);
    Vec3d q{dot(n, camera.right), -dot(n, camera.up), dot(n, camera.toward)};
    if (squared_length(q) == 0.0) return {0.0, 0.0, 1.0};
    if (q.z < 0.0) q = -q;
    q.z = std::max(q.z, kMinFacing);
    return q;
}

Vec3f color_of(const PointCloud& cloud, std::size_t p, const Vec3d& normal) {
    if (!cloud.colors.empty()) return to_linear(cloud.colors[p]);
    const auto grey = static_cast<float>(0.15 + 0.55 * normal.z / length(normal));
    return {grey, grey, grey};
}

}  // namespace

Image render_points(const PointCloud& cloud, const View& view, const Context& context) {
    const Camera camera(view, cloud.positions);
    const std::vector<float> radii = radii_of(cloud, context);
    std::vector<Disc> discs(cloud.size());
    std::vector<RowRange> ranges(cloud.size());
    std::vector<Vec3f> colors(cloud.size());
    constexpr std::size_t kGrain = 16384;
    parallel_for(context, cloud.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t p = begin; p < end; ++p) {
            const Vec3f normal = cloud.normals.empty() ? Vec3f{} : cloud.normals[p];
            Disc& d = discs[p];
            d = {camera.project(cloud.positions[p]), facing_normal(normal, camera),
                 std::max(kMinRadius, camera.scale * static_cast<double>(radii[p]))};
            ranges[p] = {static_cast<float>(d.center.y - d.radius),
                         static_cast<float>(d.center.y + d.radius)};
            colors[p] = color_of(cloud, p, d.normal);
        }
    });
    return render::draw(
        view, ranges, [&](Index p, Band& band) { rasterize_disc(discs[p], p, band); },
        [&](Index p, double, double) { return colors[p]; }, context);
}

}  // namespace pointbake
