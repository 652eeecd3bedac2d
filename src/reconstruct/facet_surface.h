// A surface made of Delaunay facets, and its way to an indexed mesh.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "reconstruct/tetrahedra.h"

namespace pointbake {

/// Half facets seen from the inner side, with the neighbour across each edge (corner k to k + 1),
/// as 3 * facet + edge, kInvalidIndex = border. Across a shared edge the two run in opposite
/// directions.
struct FacetSurface {
    std::vector<HalfFacet> facets;
    std::vector<std::array<Index, 3>> mates;
};

/// The points of each facet.
std::vector<Triangle> triangles_of(const Tetrahedra& tets, std::span<const HalfFacet> facets,
                                   const Context& context);

/// Takes facets away; edges that they were mates at become borders.
void drop_facets(std::span<const std::uint8_t> dropped, FacetSurface& surface);

struct IndexedSurface {
    std::vector<Index> vertex_points;  ///< real point under each vertex, ascending
    std::vector<Triangle> triangles;
};

/// Without the vertices that no triangle uses.
void drop_unused_vertices(IndexedSurface& surface);

/// The boundary of the inside cells: closed and oriented outwards. `inside` is changed where an
/// edge would carry more than two facets, if a small change of labels cures it; where none does,
/// facets that bound the same inner wedge are mates.
FacetSurface boundary_of(const Tetrahedra& tets, std::vector<std::uint8_t>& inside,
                         const Context& context);

/// One vertex per fan of facets: 2-manifold. Where the mates leave an edge of the index mesh with
/// more than two triangles, facets are left out if the surface `is_open`; a closed one has them
/// paired anew.
IndexedSurface split_fans(const Tetrahedra& tets, FacetSurface surface, bool is_open,
                          const Context& context);

}  // namespace pointbake
