// The part of the surface that is nearer to a point than to its neighbours.
#pragma once

#include "core/kdtree.h"
#include "pointbake/types.h"

namespace pointbake {

/// Second moments are about the centroid, along the frame's two axes.
struct TangentCell {
    double area = 0.0;
    double uu = 0.0, uv = 0.0, vv = 0.0;
    Vec3d u, v;  ///< orthonormal, in the tangent plane
};

/// The Voronoi cell of point i in its tangent plane, its neighbours laid into the plane at the
/// distances that they have in space; neighbours that face the other way are another sheet's.
/// `tree` is over the cloud's positions. The 24 nearest are asked, the 63 nearest where farther
/// ones may cut the cell, too. Where these leave it open (a border) it ends one spacing from the
/// point. Nothing for points without a normal. O(log n).
TangentCell tangent_cell(const PointCloud& cloud, Index i, const KdTree& tree);

}  // namespace pointbake
