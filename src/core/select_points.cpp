#include "core/select_points.h"

#include <algorithm>
#include <numeric>

#include "core/message.h"

namespace pointbake {
namespace {

/// Moves the entries of kept points to the front; a point has `stride` entries, or none.
template <class T>
void compact(std::vector<T>& values, std::span<const DropReason> fates, std::size_t stride = 1) {
    if (values.empty()) return;
    std::size_t end = 0;
    for (std::size_t i = 0; i < fates.size(); ++i) {
        if (fates[i] != DropReason::kKept) continue;
        for (std::size_t k = 0; k < stride; ++k) values[end++] = values[i * stride + k];
    }
    values.resize(end);
    values.shrink_to_fit();
}

void record_dropped(PointCloud& cloud, std::span<const DropReason> fates) {
    const std::vector<Vec3d>& read = cloud.measured.empty() ? cloud.positions : cloud.measured;
    for (std::size_t i = 0; i < fates.size(); ++i)
        if (fates[i] != DropReason::kKept)
            cloud.dropped.push_back({cloud.rows[i], read[i], fates[i]});
    std::ranges::sort(cloud.dropped, {}, &DroppedPoint::row);
}

}  // namespace

PointCloud select_points(PointCloud cloud, std::span<const DropReason> fates) {
    POINTBAKE_ASSERT(fates.size() == cloud.size(), "{} fates for {} points", fates.size(),
                     cloud.size());
    if (std::ranges::count(fates, DropReason::kKept) == std::ssize(fates)) return cloud;
    if (cloud.rows.empty()) {
        cloud.rows.resize(cloud.size());
        std::iota(cloud.rows.begin(), cloud.rows.end(), std::uint64_t{0});
    }
    record_dropped(cloud, fates);
    compact(cloud.positions, fates);
    compact(cloud.measured, fates);
    compact(cloud.colors, fates);
    compact(cloud.normals, fates);
    compact(cloud.given_normals, fates);
    compact(cloud.radii, fates);
    compact(cloud.areas, fates);
    compact(cloud.axes, fates);
    compact(cloud.sensors, fates);
    compact(cloud.weights, fates);
    compact(cloud.rows, fates);
    for (Channel& channel : cloud.channels) compact(channel.data, fates, channel.num_components);
    return cloud;
}

}  // namespace pointbake
