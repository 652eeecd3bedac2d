// How far a surface may be from the points, unless more was asked for.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/kdtree.h"
#include "reconstruct/facet_surface.h"

namespace pointbake {

/// Most a surface may be from the nearest point, in that point's spacings.
inline constexpr double kFarthest = 3.0;
/// How much smaller than a corner's that spacing may be and the corner's count instead.
inline constexpr double kDenser = 1.5;

/// The points as they are, with their spacing: sqrt(pi d^2 / 12), d the distance to the 12th
/// nearest other point. A view of the points, which must outlive it. Thread-safe.
class Reach {
 public:
    explicit Reach(std::span<const Vec3d> points) : points_(points), tree_(points) {}

    double spacing(Index point) const;
    /// Whether no part of the triangle is farther than kFarthest spacings from the nearest point;
    /// where that is denser than the triangle's corners, up to kDenser times as many.
    bool holds(Vec3d a, Vec3d b, Vec3d c) const;

 private:
    bool holds(Vec3d x, double corner_spacing) const;

    std::span<const Vec3d> points_;
    KdTree tree_;
};

/// Takes away the facets with parts that are too far from all points. `spacing` per point of
/// `tets`, `points` those of the input, where points of `tets` may lie in another frame.
void drop_far_facets(const Tetrahedra& tets, std::span<const float> spacing,
                     std::span<const Vec3d> points, const Reach& reach, FacetSurface& surface,
                     const Context& context);

}  // namespace pointbake
