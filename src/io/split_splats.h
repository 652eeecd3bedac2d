// Large Gaussian splats as several surfels.
#pragma once

#include <cstdint>

#include "pointbake/context.h"
#include "pointbake/types.h"

namespace pointbake {

/// A splat is as large as what it shows is plain: a wall is one, the letters on it are hundreds.
/// Points so far apart are no surface. Where a splat reaches farther than a step, points are added
/// on its ellipse, a step apart, and share its Gaussian with its own point. The step is twice the
/// median radius, or as much more as keeps those added below twice those that are there.
/// `cloud` has one entry per row, with axes, weights and areas; the rows added stand behind the
/// others. Returns how many. O(n).
std::uint64_t split_large_splats(PointCloud& cloud, const Context& context);

}  // namespace pointbake
