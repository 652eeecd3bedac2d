// Which points another layer of the surface covers.
#pragma once

#include "texture/footprints.h"

namespace pointbake {

/// Hides the points of a triangle over which others lie along the interpolated normal, with a gap
/// between: skin under cloth, the inner of two walls that simplification made one. First pass of
/// the two of [Pfister00], by surfels instead of texels: each is an opaque disc in its own plane.
/// Discs that belong to the next triangle cover nothing of this one. Linear in the points where
/// they are evenly spread within a triangle.
void hide_covered_in_place(Footprints& prints, const PointCloud& cloud, const Shell& shell,
                           const Context& context);

}  // namespace pointbake
