// A bounding volume hierarchy over triangles: closest points and rays, in double.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "pointbake/types.h"

namespace pointbake {

struct ClosestPoint {
    Index triangle = kInvalidIndex;
    Vec3d point;
    Vec3d barycentric;
    double squared_distance = 0.0;
};

struct RayHit {
    Index triangle = kInvalidIndex;
    double t = 0.0;  ///< distance along the ray, in units of its direction's length
    Vec3d barycentric;
};

/// The point of the triangle abc that is closest to p [Ericson05, 5.1.5]; barycentrics sum to 1.
ClosestPoint closest_point_on_triangle(Vec3d p, Vec3d a, Vec3d b, Vec3d c);

/// Built in O(n log n), deterministic; keeps views of its input, which must outlive it. Queries are
/// thread-safe; ties go to the lower triangle index.
class TriangleBvh {
 public:
    TriangleBvh(std::span<const Vec3d> positions, std::span<const Triangle> triangles);

    /// The closest point within max_distance, if any.
    std::optional<ClosestPoint> closest(Vec3d p, double max_distance = HUGE_VAL) const;
    /// The first hit with t in (0, max_t], from either side.
    std::optional<RayHit> first_hit(Vec3d origin, Vec3d direction, double max_t = HUGE_VAL) const;

 private:
    struct Node {
        Vec3f low, high;  ///< rounded outwards
        Index first = 0;  ///< first entry of order_ (leaf) or right child (inner; the left one
                          ///< follows the node)
        Index count = 0;  ///< 0 = inner node
    };
    std::span<const Vec3d> positions_;
    std::span<const Triangle> triangles_;
    Vec3d origin_;  ///< boxes are relative to it, so that large coordinates lose nothing
    std::vector<Node> nodes_;
    std::vector<Index> order_;

    friend class BvhBuilder;
};

}  // namespace pointbake
