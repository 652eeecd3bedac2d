#include "attributes/spacing.h"

#include <algorithm>
#include <array>

#include "core/kdtree.h"
#include "core/parallel.h"
#include "pointbake/attributes.h"

namespace pointbake {
namespace {

constexpr std::size_t kGrain = 2048;  // points per chunk: about a millisecond

/// The value with a share of `fraction` below it; reorders the values.
double quantile_in_place(std::vector<float>& values, double fraction) {
    const auto last = static_cast<double>(values.size() - 1);
    const auto at = values.begin() + static_cast<std::ptrdiff_t>(fraction * last + 0.5);
    std::nth_element(values.begin(), at, values.end());
    return static_cast<double>(*at);
}

}  // namespace

double median_spacing(std::vector<float> areas) {
    return areas.empty() ? 0.0 : std::sqrt(quantile_in_place(areas, 0.5));
}

SpacingStats spacing_stats(const PointCloud& cloud, const Context& context) {
    if (cloud.size() < 2) return {};
    const KdTree tree(cloud.positions);
    std::vector<float> distances(cloud.size());
    parallel_for(context, cloud.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        std::array<Neighbor, 2> buffer;
        for (std::size_t i = begin; i < end; ++i) {
            const auto found = tree.nearest(cloud.positions[i], buffer);
            distances[i] = static_cast<float>(std::sqrt(found.back().squared_distance));
        }
    });
    return {.median = quantile_in_place(distances, 0.5),
            .p5 = quantile_in_place(distances, 0.05),
            .p95 = quantile_in_place(distances, 0.95)};
}

}  // namespace pointbake
