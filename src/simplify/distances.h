// Distances measured at the end, by other means than those that decided.
#pragma once

#include <span>
#include <vector>

#include "pointbake/context.h"
#include "pointbake/simplify.h"

namespace pointbake {

/// Distances of all samples of `mesh` to `surface`, in units of the input. The spacing's slack is
/// added to the maximum, so that it bounds every point of the mesh.
DistanceStats mesh_to_surface(const Mesh& mesh, const Mesh& surface, const Context& context);

/// Statistics of distances; negative entries do not count.
DistanceStats summarize(std::span<const double> distances, const Context& context);

}  // namespace pointbake
