// An open surface grown over its gaps.
#pragma once

#include <span>

#include "reconstruct/facet_surface.h"
#include "reconstruct/tetrahedra.h"

namespace pointbake {

/// Adds Delaunay facets at the surface's borders, best first, as far as points are near and a facet
/// does not bend sharply away from the one that it grows from: where two sheets lie closer than
/// about two spacings Cocone leaves gaps in both. `spacing` per point. Stays oriented, at most two
/// mates per edge; two borders of one piece are never joined, so no handles arise; new facets come
/// behind the old ones. O(b log b) in the borders' edges, times the length of the borders that meet
/// (4096 at most).
void grow_in_place(const Tetrahedra& tets, std::span<const float> spacing, FacetSurface& surface,
                   const Context& context);

}  // namespace pointbake
