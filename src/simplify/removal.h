// Triangles that go without a collapse: the last resort of a budget, and those without area.
#pragma once

#include "pointbake/types.h"
#include "simplify/attribution.h"
#include "simplify/surface.h"

namespace pointbake {

/// Removes the parts of least area until at most this many triangles are left; the largest part
/// always stays. Their points are off the surface. Returns the number of parts removed.
std::size_t drop_smallest_parts(Surface& surface, Attribution& attribution, Index num_triangles);

/// Removes triangles of zero area; their points go to a neighbour.
void drop_flat_triangles(Surface& surface, Attribution& attribution);

}  // namespace pointbake
