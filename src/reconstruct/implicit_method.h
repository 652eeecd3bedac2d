// The implicit method as this stage runs it: is the surface open or closed, and what is told of it.
#pragma once

#include "pointbake/reconstruct.h"

namespace pointbake {

/// `wanted` is not kGiven; kAuto closes the surface where that adds little. All of the report but
/// what follows from the mesh. Throws Error{kInvalidInput} for a cloud without normals or areas and
/// Error{kDegenerate} where there is no surface.
ReconstructResult run_implicit(const PointCloud& cloud, Surface wanted, double max_added,
                               const Context& context);

}  // namespace pointbake
