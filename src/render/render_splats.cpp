// Splats are laid over each other in the order of their centres' depths, as trained models expect
// it, and in display codes, in which they were trained.
#include "render/render_splats.h"

#include <algorithm>
#include <cmath>

#include "core/color.h"
#include "core/kernel.h"
#include "core/parallel.h"
#include "core/splat.h"
#include "render/canvas.h"

namespace pointbake::render {
namespace {

constexpr float kLeastOpacity = 1.0F / 255.0F, kDark = 1e-3F;
// Variance of the screen filter in squared pixels, for half a sample.
constexpr double kLowPass = 0.25 / (kSuper * kSuper);

/// A Gaussian on the picture.
struct Blot {
    Vec3d center;             // x, y and depth in pixels
    double qxx, qxy, qyy;     // inverse covariance
    double reach_x, reach_y;  // half its box
    float opacity = 0.0F;
    Vec3f color;  // display codes, 0 to 1
};

Vec3f color_of(const PointCloud& cloud, std::size_t p) {
    if (cloud.colors.empty()) return {0.5F, 0.5F, 0.5F};
    const Rgb16 c = cloud.colors[p];
    return Vec3f{static_cast<float>(c.r), static_cast<float>(c.g), static_cast<float>(c.b)} /
           65535.0F;
}

Blot blot_of(const PointCloud& cloud, std::size_t p, const Camera& camera) {
    const Splat splat = splat_of(cloud, p);
    Blot out;
    out.center = camera.project(splat.center);
    double xx = kLowPass, xy = 0.0, yy = kLowPass;
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec3d a =
            camera.turn(vec_cast<double>(splat.axes[k] * splat.sigmas[k])) * camera.scale;
        xx += a.x * a.x, xy += a.x * a.y, yy += a.y * a.y;
    }
    const double det = xx * yy - xy * xy;
    out.qxx = yy / det, out.qxy = -xy / det, out.qyy = xx / det;
    out.reach_x = static_cast<double>(kSplatCut) * std::sqrt(xx);
    out.reach_y = static_cast<double>(kSplatCut) * std::sqrt(yy);
    out.opacity = splat.opacity;
    out.color = color_of(cloud, p);
    return out;
}

void lay_under(const Blot& blot, Index id, Band& band, std::vector<float>& passed) {
    if (blot.opacity < kLeastOpacity) return;
    const auto [first, last] =
        band.rows_between(blot.center.y - blot.reach_y, blot.center.y + blot.reach_y);
    const auto [begin, end] =
        band.columns_between(blot.center.x - blot.reach_x, blot.center.x + blot.reach_x);
    for (int row = first; row < last; ++row)
        for (int column = begin; column < end; ++column) {
            const std::size_t k = band.sample(row, column);
            const double x = band.sample_x(column) - blot.center.x,
                         y = band.sample_y(row) - blot.center.y;
            const double q = blot.qxx * x * x + 2.0 * blot.qxy * x * y + blot.qyy * y * y;
            if (passed[k] < kDark || q >= static_cast<double>(kSplatCut * kSplatCut)) continue;
            const float opacity = blot.opacity * gaussian(static_cast<float>(q));
            if (opacity < kLeastOpacity) continue;
            band.color[k] += blot.color * (passed[k] * opacity);
            passed[k] *= 1.0F - opacity;
            if (passed[k] <= 0.5F && band.id[k] == kInvalidIndex) band.id[k] = id;
        }
}

}  // namespace

Image render_splats(const PointCloud& cloud, const View& view, const Context& context) {
    const Camera camera(view, cloud.positions);
    std::vector<Blot> blots(cloud.size());
    std::vector<RowRange> ranges(cloud.size());
    constexpr std::size_t kGrain = 16384;
    parallel_for(context, cloud.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t p = begin; p < end; ++p) {
            const Blot& b = blots[p] = blot_of(cloud, p, camera);
            ranges[p] = {static_cast<float>(b.center.y - b.reach_y),
                         static_cast<float>(b.center.y + b.reach_y)};
        }
    });
    return draw(
        view, ranges,
        [&](std::span<const Index> points, Band& band) {
            std::vector<Index> order(points.begin(), points.end());
            std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) {
                return blots[a].center.z > blots[b].center.z;
            });
            std::vector<float> passed(band.id.size(), 1.0F);
            for (const Index p : order) lay_under(blots[p], p, band, passed);
            for (std::size_t k = 0; k < passed.size(); ++k) {
                if (band.id[k] == kInvalidIndex) continue;
                const Vec3f code = band.color[k] * (65535.0F / (1.0F - passed[k]));
                const auto coded = [](float x) {
                    return static_cast<std::uint16_t>(std::min(x + 0.5F, 65535.0F));
                };
                band.color[k] = to_linear({coded(code.x), coded(code.y), coded(code.z)});
            }
        },
        context);
}

}  // namespace pointbake::render
