// Which points a smooth surface needs.
#pragma once

#include <vector>

#include "pointbake/context.h"
#include "pointbake/types.h"

namespace pointbake {

/// Ids, ascending, of points that tell the shape as well as all do. Where the surface bends little
/// they lie farther apart, by r = sqrt(2 t / k) at a curvature of k: a triangle within a disc of
/// radius r is no farther than t from the surface, t being `tolerance` of the spacing there, at
/// most `most_length`. All points stay on borders and creases, where they scatter by more than half
/// of t, and where another sheet is nearer than four of the new spacings. Three rounds, each of
/// which keeps points at most two spacings apart: some 16 of the first ones at the end. The order
/// of the points decides nothing, but searches are fast if they come sorted by place. O(n log n).
std::vector<Index> thin_smooth(std::vector<Vec3d> points, double tolerance, double most_length,
                               const Context& context);

}  // namespace pointbake
