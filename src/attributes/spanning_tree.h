// Orientation of normals without a surface.
#pragma once

#include "pointbake/context.h"
#include "pointbake/types.h"

namespace pointbake {

/// Turns the cloud's normals so that neighbours agree, and so that in each connected part of the
/// neighbour graph the topmost one points up. Unknown normals stay. Returns how many were turned.
/// O(n log n). Right on closed, smooth, well separated parts; across creases, between thin sheets
/// and on inner shells it can be wrong.
std::uint64_t orient_by_spanning_tree_in_place(PointCloud& cloud, const Context& context);

}  // namespace pointbake
