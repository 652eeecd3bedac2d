// Which points a surface is made of.
#pragma once

#include <span>
#include <vector>

#include "pointbake/context.h"
#include "pointbake/types.h"

namespace pointbake {

/// Ids, ascending, of points no two of which are nearer to each other than `share` of the smaller
/// of their spacings (those of squares as dense as the 12 nearest neighbours): noise between nearer
/// ones folds the surface. Greedy in the order of a hash of the coordinates [Cook86], so that the
/// order of the points does not matter. share <= 1.9. O(n log n).
std::vector<Index> thin(std::span<const Vec3d> points, double share, const Context& context);

}  // namespace pointbake
