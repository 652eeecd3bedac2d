// From Cocone's facets to an oriented surface with borders.
#pragma once

#include "reconstruct/cocone.h"
#include "reconstruct/facet_surface.h"

namespace pointbake {

/// Facets that hang over at points with a whole umbrella are pruned, then the surface is walked: at
/// each edge the first facet on the walker's side is the neighbour and the others go. Slivers are
/// so resolved to one side. At most two mates per edge. Umbrellas of slivers do not count as whole
/// where they are flat, as regular grids of points have them, nor in clouds that are or were noisy
/// (`is_noisy`); others may, as sheets close by are full of them.
FacetSurface extract_open(const Tetrahedra& tets, const Cocone& cocone, bool is_noisy,
                          const Context& context);

}  // namespace pointbake
