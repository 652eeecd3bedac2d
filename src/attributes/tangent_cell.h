// The part of the surface that is nearer to a point than to its neighbours.
#pragma once

#include <span>

#include "core/kdtree.h"
#include "pointbake/types.h"

namespace pointbake {

/// Second moments are about the centroid, along the frame's two axes.
struct TangentCell {
    double area = 0.0;
    double uu = 0.0, uv = 0.0, vv = 0.0;
    Vec3d u, v;  ///< orthonormal, in the tangent plane
};

/// Neighbours that a cell is cut with, the point itself among them.
inline constexpr std::size_t kCellNeighbors = 25;

/// The Voronoi cell of point i among its neighbours, ordered by distance, laid into its tangent
/// plane at the distances that they have in space; neighbours that face the other way are another
/// sheet's. No farther from the point than one spacing, where nothing ends it. O(neighbours).
TangentCell tangent_cell(const PointCloud& cloud, Index i, std::span<const Neighbor> neighbors);

}  // namespace pointbake
