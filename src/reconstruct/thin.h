// Which points a surface is made of.
#pragma once

#include <cmath>
#include <span>
#include <vector>

#include "pointbake/context.h"
#include "pointbake/types.h"

namespace pointbake {

/// In spacings, those of squares as dense as the nearest neighbours, and as a length.
struct ThinRule {
    double nearest = 0.0;           ///< no two points stay that are nearer to each other; <= 1.9
    double tolerance = 0.0;         ///< what smooth parts may lose; 0 = all points stay there
    double most_length = HUGE_VAL;  ///< they never lose more than this
};

/// Ids, ascending, of points no two of which are nearer to each other than `nearest` of the smaller
/// of their spacings, as noise between nearer ones folds the surface; of these, where the surface
/// is smooth, those that tell its shape (thin_smooth.h). The order of the points does not matter.
/// O(n log n).
std::vector<Index> thin(std::span<const Vec3d> points, ThinRule rule, const Context& context);

}  // namespace pointbake
