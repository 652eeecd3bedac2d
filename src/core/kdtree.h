// Nearest neighbours of points in space (nanoflann behind it).
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "pointbake/types.h"

namespace pointbake {

struct Neighbor {
    Index index = kInvalidIndex;
    double squared_distance = 0.0;
};

/// Built in O(n log n); keeps a view of the positions, which must outlive it. Queries are
/// thread-safe.
class KdTree {
 public:
    explicit KdTree(std::span<const Vec3d> positions);
    ~KdTree();
    KdTree(KdTree&&) noexcept;

    /// The k nearest points, ordered by (distance, index); fewer if there are fewer. Fills and
    /// returns `out`'s prefix.
    std::span<Neighbor> nearest(Vec3d query, std::span<Neighbor> out) const;

    /// Whether another point than this one is nearer to it than that, or in the same place.
    bool has_nearer(Index point, double squared_distance) const;

    /// Whether any point is nearer to the place than that, give or take the rounding.
    bool has_within(Vec3d place, double squared_distance) const;

 private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace pointbake
