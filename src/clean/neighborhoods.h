// The nearest neighbours of every point, found once for all that cleaning asks.
#pragma once

#include <span>
#include <vector>

#include "core/kdtree.h"
#include "pointbake/context.h"
#include "pointbake/types.h"

namespace pointbake {

inline constexpr std::size_t kNeighbors = 16;      // as many as a normal is estimated from
inline constexpr std::size_t kCloseNeighbors = 6;  // about the first ring

struct Neighborhoods {
    std::span<const Vec3d> positions;
    KdTree tree;
    std::vector<Index> neighbors;  ///< kNeighbors of each point, by (distance, index)
    std::vector<double> reach;     ///< mean distance to them
    std::vector<double> spacing;   ///< mean distance to the first kCloseNeighbors

    std::span<const Index> of(std::size_t point) const {
        return std::span(neighbors).subspan(point * kNeighbors, kNeighbors);
    }
};

/// More than kNeighbors points, which must outlive the result. O(n log n).
Neighborhoods find_neighborhoods(std::span<const Vec3d> positions, const Context& context);

}  // namespace pointbake
