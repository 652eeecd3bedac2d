#include "reconstruct/spacing.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"

namespace pointbake {
namespace {

// Distance to this Delaunay neighbour: high enough that points on scan lines count points of the
// next line too, or nearly.
constexpr std::size_t kSpacingRank = 6;
// It grows from point to point by at most this share of their distance.
constexpr double kSpacingSlope = 0.1;
constexpr std::size_t kGrain = 1U << 11;

// Calls body(q) for the real Delaunay neighbours of v: each lies in several of its cells, and is
// met once, or seldom more.
template <class Body>
void for_each_neighbor(const Tetrahedra& tets, Index v, Body&& body) {
    std::array<Index, 64> seen;  // the last one of each remainder
    seen.fill(v);
    for (Index c : tets.star(v)) {
        for (Index q : tets.cells[c]) {
            Index& last = seen[q % seen.size()];
            if (q == last || q == v || tets.is_far(q)) continue;
            last = q;
            body(q);
        }
    }
}

// Keeps the nearest Delaunay neighbours seen so far in order.
float measure(const Tetrahedra& tets, Index v) {
    std::array<std::pair<double, Index>, kSpacingRank> nearest;
    std::size_t count = 0;
    for_each_neighbor(tets, v, [&](Index q) {
        const std::pair entry(squared_length(tets.points[q] - tets.points[v]), q);
        if (count == kSpacingRank && entry.first > nearest.back().first) return;
        const auto end = nearest.begin() + static_cast<std::ptrdiff_t>(count);
        const auto place = std::lower_bound(nearest.begin(), end, entry);
        if (place == nearest.end() || (place != end && *place == entry)) return;
        if (count < kSpacingRank) ++count;
        std::copy_backward(place, nearest.begin() + static_cast<std::ptrdiff_t>(count) - 1,
                           nearest.begin() + static_cast<std::ptrdiff_t>(count));
        *place = entry;
    });
    return count == 0 ? 0.0F : static_cast<float>(std::sqrt(nearest[count - 1].first));
}

// A lone point has far neighbours; next to dense ones it counts as dense as well.
float level(const Tetrahedra& tets, const std::vector<float>& measured, Index v) {
    float spacing = measured[v];
    for_each_neighbor(tets, v, [&](Index q) {
        if (measured[q] >= spacing) return;
        const double reach = measured[q] + kSpacingSlope * length(tets.points[q] - tets.points[v]);
        spacing = std::min(spacing, static_cast<float>(reach));
    });
    return spacing;
}

}  // namespace

std::vector<float> local_spacing(const Tetrahedra& tets, const Context& context) {
    std::vector<float> measured(tets.num_real()), leveled(tets.num_real());
    parallel_for(context, measured.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v)
            measured[v] = measure(tets, static_cast<Index>(v));
    });
    parallel_for(context, leveled.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v)
            leveled[v] = level(tets, measured, static_cast<Index>(v));
    });
    return leveled;
}

}  // namespace pointbake
