// Leaving points out of a cloud: all its arrays together.
#pragma once

#include <span>

#include "pointbake/types.h"

namespace pointbake {

/// Keeps the points whose fate is kKept, in their order; the others go to cloud.dropped, which
/// stays ordered by row. Points without rows are numbered first. One fate per point. O(n).
PointCloud select_points(PointCloud cloud, std::span<const DropReason> fates);

}  // namespace pointbake
