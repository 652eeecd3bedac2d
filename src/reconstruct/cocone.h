// Cocone with boundary detection: which Delaunay facets belong to the surface.
#pragma once

#include <cstdint>
#include <vector>

#include "reconstruct/tetrahedra.h"

namespace pointbake {

/// Bits of a facet.
enum FacetFlag : std::uint8_t {
    kSurfaceFacet = 1,  ///< chosen by the flat vertices: the surface of [Dey03]
    kAgreedFacet = 2,   ///< in the co-cone of all three vertices: the candidates of [Amenta02]
};

struct Cocone {
    std::vector<Vec3d> normals;        ///< unit, direction of the pole; sign without meaning
    std::vector<float> spacing;        ///< distance to the 6th nearest Delaunay neighbour
    std::vector<std::uint8_t> flat;    ///< 1 = well sampled, inside the surface
    std::vector<std::uint8_t> facets;  ///< flags per half facet, the same on both sides
    Index num_flat = 0;

    bool is_surface(HalfFacet facet) const { return (facets[facet] & kSurfaceFacet) != 0; }
};

/// O(cells), on all threads.
Cocone find_cocone(const Tetrahedra& tets, const Context& context);

}  // namespace pointbake
