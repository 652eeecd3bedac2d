// The smallest box around points in a plane.
#pragma once

#include <vector>

#include "pointbake/vec.h"

namespace pointbake {

/// A turn of the plane, and the box that points are in after it.
struct TurnedBox {
    Vec2d along{1.0, 0.0};  ///< becomes the x axis
    Vec2d low{}, high{};
    Vec2d place(Vec2d x) const { return {dot(along, x), cross(along, x)}; }
    double area() const { return (high.x - low.x) * (high.y - low.y); }
};

/// The turn with the smallest box, a side of which lies on the convex hull. O(n log n + h^2) for h
/// points on the hull.
TurnedBox least_box(const std::vector<Vec2d>& points);

}  // namespace pointbake
