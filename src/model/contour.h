// A signed function becomes a closed mesh that keeps its creases.
#pragma once

#include "pointbake/context.h"
#include "pointbake/types.h"

namespace pointbake {

/// A solid, given by functions of space.
struct Solid {
    double (*value)(Vec3d) = nullptr;  ///< negative inside, positive outside, continuous
    Vec3d (*normal)(Vec3d) = nullptr;  ///< outward unit normal of the level set through a point
    double steepness = 1.1;            ///< the value changes by at most this per unit of length
};

/// Cubic cells; the solid must be positive on the outermost lattice points.
struct ContourGrid {
    static constexpr int kBlock = 8;  ///< blocks of 8^3 cells far from the surface are skipped
    Vec3d low;                        ///< first lattice point
    double spacing = 0.0;
    std::array<int, 3> num_blocks{};
};

/// The zero set: one vertex per sheet of surface in a cell, placed on the crease or corner if there
/// is one and else on the surface; quads across the lattice's edges, cut into two triangles each.
/// Closed and oriented; a 2-manifold unless two sheets cross the same face of the same two cells.
Mesh contour(const Solid& solid, const ContourGrid& grid, const Context& context = {});

}  // namespace pointbake
