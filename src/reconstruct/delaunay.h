// The Delaunay tetrahedralization of points, as plain arrays.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "pointbake/context.h"
#include "pointbake/types.h"

namespace pointbake {

struct Delaunay {
    /// Point ids of each finite cell, positively oriented: (b - a) . ((c - a) x (d - a)) > 0. In
    /// ascending order but for the last two, which are swapped where orientation asks for it.
    std::vector<std::array<Index, 4>> cells;
    /// neighbors[c][i] is the cell across the facet opposite vertex i, kInvalidIndex outside the
    /// convex hull.
    std::vector<std::array<Index, 4>> neighbors;
};

/// False where the program is built without a triangulation (-DPOINTBAKE_CGAL=OFF).
bool has_delaunay();

/// Tetrahedralizes the points with the given ids (all of them if `subset` is empty). Points must be
/// finite and distinct; neighbours in `points` should be near each other in space (Morton order),
/// which decides speed alone. Exact predicates and a symbolic perturbation that depends on
/// coordinates only: the cells are unique, also for cospherical points, and come in ascending order
/// of their vertices, for any number of threads. Fewer than 4 points or coplanar ones give no
/// cells. Near linear time, about 0.5 kB per point while it runs, on one thread but for
/// the last part. Throws Error{kCancelled}, and
/// Error{kUnsupported} where the program is built without a triangulation.
Delaunay delaunay(std::span<const Vec3d> points, const Context& context = {},
                  std::span<const Index> subset = {});

}  // namespace pointbake
