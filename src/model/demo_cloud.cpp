// The demo model as a scan: denser in front, as if the scanner stood there.
#include <algorithm>
#include <cmath>

#include "core/color.h"
#include "core/message.h"
#include "core/parallel.h"
#include "model/darts.h"
#include "pointbake/model.h"

namespace pointbake {
namespace {

constexpr double kDensityRatio = 4.0;

// The front is four times as dense as the back, with a smooth step between.
double density_at(Vec3d p) {
    constexpr double kReach = 0.62;  // beyond it, towards front and back, the density is constant
    const double t = std::clamp(0.5 + 0.5 * p.z / kReach, 0.0, 1.0);
    return 1.0 + (kDensityRatio - 1.0) * t * t * (3.0 - 2.0 * t);
}

}  // namespace

PointCloud demo_cloud(std::uint64_t points, const Context& context) {
    constexpr std::uint64_t kMaxPoints = 100'000'000;
    if (points < 1 || points > kMaxPoints)
        fail(ErrorCode::kInvalidOption, "a demo cloud of {} points: 1 to {} can be made", points,
             kMaxPoints);
    const Mesh mesh = demo_mesh();
    Box box;
    for (const Vec3d& p : mesh.positions) box.extend(p);
    const Vec3d extent = box.extent();
    const double longest = std::max({extent.x, extent.y, extent.z});
    const std::vector<SurfacePoint> spread = spread_points(mesh, &density_at, points, context);

    PointCloud cloud;
    cloud.num_rows = points;
    cloud.positions.resize(points);
    cloud.colors.resize(points);
    cloud.rows.resize(points);
    constexpr std::size_t kGrain = 4096;
    parallel_for(context, points, kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
            const Vec3d p = spread[k].position;
            cloud.positions[k] = p;
            cloud.colors[k] = rounded_to_8bit(
                paint_at((p - box.low) / longest, vec_cast<double>(spread[k].normal)));
            cloud.rows[k] = k;
        }
    });
    return cloud;
}

}  // namespace pointbake
