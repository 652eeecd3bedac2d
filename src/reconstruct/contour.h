// The zero set of values on a grid of tetrahedra, as a triangle mesh.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "reconstruct/simplex_grid.h"

namespace pointbake {

/// A mesh vertex: on the grid's edge from a node outside to one inside, or, if both are the same, a
/// grid vertex that was moved onto the surface.
struct ContourVertex {
    Index outside, inside;
    bool is_snapped() const { return outside == inside; }
};

struct Contour {
    std::vector<ContourVertex> vertices;
    std::vector<Triangle> triangles;  ///< counter-clockwise seen from outside
};

/// Values per node, positive outside; where one is NaN the tetrahedra are left out. Grid vertices
/// near the surface are moved onto it where `may_snap`, which takes away most slivers and half of
/// the triangles. 2-manifold, closed but for tetrahedra left out. Near linear time.
Contour find_contour(const SimplexGrid& grid, std::span<const float> values,
                     std::span<const std::uint8_t> may_snap, const Context& context);

}  // namespace pointbake
