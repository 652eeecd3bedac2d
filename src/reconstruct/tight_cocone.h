// Tight Cocone: which tetrahedra are inside.
#pragma once

#include <cstdint>
#include <vector>

#include "reconstruct/cocone.h"
#include "reconstruct/facet_surface.h"
#include "reconstruct/tetrahedra.h"

namespace pointbake {

struct InsideLabels {
    std::vector<std::uint8_t>
        inside;               ///< 1 per cell inside, 0 outside; cells at far points are out
    Index num_poor = 0;       ///< points without a good umbrella
    Index num_conflicts = 0;  ///< cells that got both labels
};

/// Labels every cell; near linear. `surface` is what was walked of Cocone's facets.
InsideLabels label_cells(const Tetrahedra& tets, const Cocone& cocone, const FacetSurface& surface,
                         const Context& context);

}  // namespace pointbake
