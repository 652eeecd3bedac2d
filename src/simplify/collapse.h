// The edge collapses: order by quadrics, legality by topology, shape, orientation and attribution.
#pragma once

#include "pointbake/context.h"
#include "pointbake/types.h"
#include "simplify/attribution.h"
#include "simplify/surface.h"

namespace pointbake {

struct CollapseLimits {
    Index num_triangles = 0;                          ///< stop when no more are left
    double squared_distance = HUGE_VAL;               ///< of any attributed point to its triangle
    double progress_begin = 0.0, progress_end = 1.0;  ///< share of the stage's progress
};

struct CollapseCounts {
    std::uint64_t num_collapses = 0, num_rejected_by_bound = 0, num_rejected_by_topology = 0,
                  num_rejected_by_shape = 0, num_triangles_removed = 0, num_parts_removed = 0;
};

/// Collapses edges until a limit is reached or nothing legal is left. Without a bound on the
/// distance, rules on shape and orientation are loosened in steps while the number is not reached.
CollapseCounts collapse_edges_in_place(Surface& surface, Attribution& attribution,
                                       const CollapseLimits& limits, const Context& context);

}  // namespace pointbake
