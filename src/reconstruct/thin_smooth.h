// Which points a smooth surface needs.
#pragma once

#include <span>
#include <vector>

#include "pointbake/context.h"
#include "pointbake/types.h"

namespace pointbake {

/// Ids, ascending, of points that tell the shape as well as all do: where the surface bends little
/// they lie farther apart, by r = sqrt(2 t / k) at a curvature of k: a triangle within a disc of
/// radius r is no farther than t from the surface, t being `tolerance` of the spacing there,
/// at most `most_length`. Everything stays near borders and
/// creases, where points scatter by more than that, and where another sheet is nearer than four of
/// the new spacings; at most one point of 64 stays elsewhere. The points should come sorted by
/// place: searches are fast then. O(n log n).
std::vector<Index> thin_smooth(std::span<const Vec3d> points, double tolerance,
                               double most_length, const Context& context);

}  // namespace pointbake
