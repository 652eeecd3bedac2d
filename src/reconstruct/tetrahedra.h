// Points, their Delaunay tetrahedra and who touches whom: what every method of this stage walks on.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "pointbake/context.h"
#include "pointbake/types.h"

namespace pointbake {

/// Corners of the facet opposite vertex i of a positively oriented cell, counter-clockwise seen
/// from outside the cell.
inline constexpr std::array<std::array<std::size_t, 3>, 4> kFacetCorners{
    {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

/// A facet seen from one of its two cells: 4 * cell + vertex of the cell opposite to it.
using HalfFacet = Index;

/// The points come in an order that depends on their coordinates alone, so that nothing which
/// follows depends on the order of the input. Behind the real ones lie far points on a sphere: with
/// them every real Voronoi cell is bounded and the convex hull needs no special case.
struct Tetrahedra {
    std::vector<Vec3d> points;
    std::vector<Index> point_ids;  ///< index in the input of each real point
    std::vector<std::array<Index, 4>> cells;
    std::vector<std::array<Index, 4>> neighbors;
    std::vector<Index> star_begin, star_items;

    Index num_real() const { return static_cast<Index>(point_ids.size()); }
    Index num_cells() const { return static_cast<Index>(cells.size()); }
    bool is_far(Index vertex) const { return vertex >= num_real(); }
    bool has_far(Index cell) const {
        const auto& c = cells[cell];
        return is_far(c[0]) || is_far(c[1]) || is_far(c[2]) || is_far(c[3]);
    }
    /// Cells around a vertex, ascending.
    std::span<const Index> star(Index vertex) const {
        return std::span(star_items)
            .subspan(star_begin[vertex], star_begin[vertex + 1] - star_begin[vertex]);
    }
    /// Which of the cell's vertices this is.
    std::size_t slot(Index cell, Index vertex) const {
        const auto& c = cells[cell];
        return c[0] == vertex ? 0 : (c[1] == vertex ? 1 : (c[2] == vertex ? 2 : 3));
    }
    /// The same facet seen from the other cell; kInvalidIndex on the convex hull of the far points.
    HalfFacet mirror(HalfFacet facet) const {
        const Index cell = facet / 4, other = neighbors[cell][facet % 4];
        if (other == kInvalidIndex) return kInvalidIndex;
        const auto& n = neighbors[other];
        const Index k = n[0] == cell ? 0 : (n[1] == cell ? 1 : (n[2] == cell ? 2 : 3));
        return other * 4 + k;
    }
    /// Counter-clockwise seen from outside the cell.
    Triangle triangle(HalfFacet facet) const {
        const auto& c = cells[facet / 4];
        const auto& k = kFacetCorners[facet % 4];
        return {c[k[0]], c[k[1]], c[k[2]]};
    }
    /// (b - a) x (c - a) of that triangle.
    Vec3d area_vector(HalfFacet facet) const {
        const auto [a, b, c] = triangle(facet);
        return cross(points[b] - points[a], points[c] - points[a]);
    }
};

/// Squared radius of the facet's circumcircle; infinite if it has no area.
double circumradius2(const Tetrahedra& tets, HalfFacet facet);

/// A step around an edge: the cell, the slot of the facet through which it is left, and the third
/// vertex of that facet.
struct Turn {
    Index cell;
    std::size_t exit;
    Index third;
};
/// From a facet of a cell around its edge (corner k to k + 1), into the cell.
Turn first_turn(const Tetrahedra& tets, HalfFacet facet, std::size_t edge);
/// Through the exit into the next cell around the same edge; there must be one.
Turn next_turn(const Tetrahedra& tets, const Turn& turn);

/// Ids along a Morton curve, ties by coordinates, equal points by id.
std::vector<Index> order_by_place(std::span<const Vec3d> points, const Context& context);

/// Sorts, merges equal points, adds the far ones, tetrahedralizes. Throws as delaunay() does.
Tetrahedra tetrahedralize(std::span<const Vec3d> points, const Context& context);

}  // namespace pointbake
