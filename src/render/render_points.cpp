// Points as EWA splats, in two passes over each band: opaque discs find the front sheet, then the
// Gaussians that lie on it are summed and normalised.
#include <algorithm>
#include <cmath>

#include "core/color.h"
#include "core/kdtree.h"
#include "core/kernel.h"
#include "core/parallel.h"
#include "render/canvas.h"
#include "render/render_splats.h"

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
// Variance of the screen filter in squared pixels, for half a sample.
constexpr double kLowPass = 0.25 / (render::kSuper * render::kSuper);

// A lone point stands for nobody's surface: no disc is larger than so many median ones.
constexpr float kMostRadius = 3.0F;

void limit_in_place(std::vector<float>& radii) {
    if (radii.empty()) return;
    std::vector<float> sorted = radii;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    if (!(*middle > 0.0F)) return;
    for (float& r : radii) r = std::min(r, kMostRadius * *middle);
}

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

// A point on the picture. Its disc says what is covered, its Gaussian how much it counts.
struct Disc {
    Vec3d center;             // x, y and depth in pixels
    Vec2d slope;              // of the depth over the picture
    double radius = 0.0;      // of the disc
    double qxx, qxy, qyy;     // inverse covariance of the Gaussian
    double reach_x, reach_y;  // half the Gaussian's box
    Vec3f color;
};

// Normal in picture axes, turned to the viewer; straight at the viewer if unknown.
Vec3d facing_normal(Vec3f normal, const Camera& camera) {
    const Vec3d q = camera.turn(vec_cast<double>(normal));
    if (squared_length(q) == 0.0) return {0.0, 0.0, 1.0};
    return q.z < 0.0 ? -q : q;
}

Vec3f color_of(const PointCloud& cloud, std::size_t p, const Vec3d& normal) {
    if (!cloud.colors.empty()) return to_linear(cloud.colors[p]);
    const auto grey = static_cast<float>(0.15 + 0.55 * normal.z / length(normal));
    return {grey, grey, grey};
}

// V = J J^T + the screen filter, J the tangent axes on the picture [Zwicker01].
void set_gaussian(const PointCloud& cloud, std::size_t p, const Camera& camera, const Vec3d& normal,
                  const Kernel& kernel, Disc& s) {
    double xx = kLowPass, xy = 0.0, yy = kLowPass;
    if (!cloud.axes.empty()) {
        for (const Vec3f& axis : {cloud.axes[p].u, cloud.axes[p].v}) {
            const Vec3d a = camera.turn(vec_cast<double>(axis)) * camera.scale;
            xx += a.x * a.x, xy += a.x * a.y, yy += a.y * a.y;
        }
    } else {
        // A circle of this plane: sigma^2 (1 - n n^T).
        const double spacing = cloud.areas.empty()
                                   ? s.radius
                                   : camera.scale * std::sqrt(static_cast<double>(cloud.areas[p]));
        const double sigma = static_cast<double>(kernel.sigma) * spacing, variance = sigma * sigma;
        const Vec3d n = normalized(normal);
        xx += variance * (1.0 - n.x * n.x);
        xy -= variance * n.x * n.y;
        yy += variance * (1.0 - n.y * n.y);
    }
    const double det = xx * yy - xy * xy;
    s.qxx = yy / det, s.qxy = -xy / det, s.qyy = xx / det;
    s.reach_x = static_cast<double>(kernel.cut) * std::sqrt(xx);
    s.reach_y = static_cast<double>(kernel.cut) * std::sqrt(yy);
}

Disc disc_of(const PointCloud& cloud, std::size_t p, double radius, const Camera& camera,
             const Kernel& kernel) {
    const Vec3d normal = facing_normal(cloud.normals.empty() ? Vec3f{} : cloud.normals[p], camera);
    Disc s;
    s.center = camera.project(cloud.positions[p]);
    const double facing = std::max(normal.z, kMinFacing);
    s.slope = {-normal.x / facing, -normal.y / facing};
    s.radius = std::max(kMinRadius, camera.scale * radius);
    s.color = color_of(cloud, p, normal);
    set_gaussian(cloud, p, camera, normal, kernel, s);
    return s;
}

// Calls visit(row, column, dx, dy, depth) for the samples of a band in a box around the centre.
template <class Visit>
void for_samples(const Disc& s, double reach_x, double reach_y, const Band& band, Visit&& visit) {
    const auto [first, last] = band.rows_between(s.center.y - reach_y, s.center.y + reach_y);
    const auto [begin, end] = band.columns_between(s.center.x - reach_x, s.center.x + reach_x);
    for (int row = first; row < last; ++row)
        for (int column = begin; column < end; ++column) {
            const double x = band.sample_x(column) - s.center.x;
            const double y = band.sample_y(row) - s.center.y;
            visit(row, column, x, y, s.slope.x * x + s.slope.y * y);
        }
}

void cover(const Disc& s, Index id, Band& band) {
    for_samples(s, s.radius, s.radius, band,
                [&](int row, int column, double x, double y, double z) {
                    if (x * x + y * y + z * z <= s.radius * s.radius)
                        band.offer(row, column, static_cast<float>(s.center.z + z), id);
                });
}

// Front sheet: no farther behind the nearest disc than one radius.
void add(const Disc& s, const Kernel& kernel, Band& band, std::vector<float>& weights) {
    for_samples(s, s.reach_x, s.reach_y, band,
                [&](int row, int column, double x, double y, double z) {
                    const double q = s.qxx * x * x + 2.0 * s.qxy * x * y + s.qyy * y * y;
                    const std::size_t k = band.sample(row, column);
                    if (q >= static_cast<double>(kernel.cut2) ||
                        s.center.z + z < static_cast<double>(band.depth[k]) - s.radius)
                        return;
                    const float w = kernel(static_cast<float>(q));
                    band.color[k] += s.color * w;
                    weights[k] += w;
                });
}

}  // namespace

Image render_points(const PointCloud& cloud, const View& view, const Context& context) {
    if (cloud.are_splats) return render::render_splats(cloud, view, context);
    const Camera camera(view, cloud.positions);
    std::vector<float> radii = radii_of(cloud, context);
    limit_in_place(radii);
    const Kernel kernel;
    std::vector<Disc> discs(cloud.size());
    std::vector<RowRange> ranges(cloud.size());
    constexpr std::size_t kGrain = 16384;
    parallel_for(context, cloud.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t p = begin; p < end; ++p) {
            const Disc& s = discs[p] =
                disc_of(cloud, p, static_cast<double>(radii[p]), camera, kernel);
            const double reach = std::max(s.radius, s.reach_y);
            ranges[p] = {static_cast<float>(s.center.y - reach),
                         static_cast<float>(s.center.y + reach)};
        }
    });
    return render::draw(
        view, ranges,
        [&](std::span<const Index> points, Band& band) {
            std::vector<float> weights(band.id.size());
            for (const Index p : points) cover(discs[p], p, band);
            for (const Index p : points) add(discs[p], kernel, band, weights);
            for (std::size_t k = 0; k < weights.size(); ++k) {
                if (band.id[k] == kInvalidIndex) continue;
                band.color[k] = weights[k] > 0.0F ? band.color[k] * (1.0F / weights[k])
                                                  : discs[band.id[k]].color;
            }
        },
        context);
}

}  // namespace pointbake
