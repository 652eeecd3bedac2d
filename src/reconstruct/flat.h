// Clouds without volume: in a plane, on a line, in a point.
#pragma once

#include <span>
#include <vector>

#include "pointbake/types.h"

namespace pointbake {

/// A plane through the points, if they lie in one up to rounding.
struct FlatFrame {
    bool is_flat = false;
    Vec3d origin, u, v;  ///< u and v: orthonormal axes in the plane
};

/// Throws Error{kDegenerate} for fewer than 3 distinct points or collinear ones.
FlatFrame find_plane(std::span<const Vec3d> points);

/// Coordinates in the plane, with z = 0 exactly.
std::vector<Vec3d> project(std::span<const Vec3d> points, const FlatFrame& frame);

}  // namespace pointbake
