// Which triangle each point belongs to: the attribution test that makes the bound honest.
#pragma once

#include <span>
#include <vector>

#include "pointbake/context.h"
#include "pointbake/types.h"
#include "simplify/face_frame.h"
#include "simplify/surface.h"

namespace pointbake {

/// One chain of points per triangle. A point in no chain is off the surface.
struct Attribution {
    std::vector<Vec3d> points;        ///< in the surface's coordinates
    std::vector<Vec3f> normals;       ///< of the dense surface at each point; zero = unknown
    std::vector<float> weights;       ///< area of the dense surface that a point stands for
    std::vector<Index> owners;        ///< per point, at first; kInvalidIndex = off the surface
    std::vector<double> distances;    ///< per point, to the dense surface
    std::vector<Index> first_points;  ///< per triangle
    std::vector<Index> next_points;   ///< per point

    template <class Body>
    void for_each_point(Index triangle, Body&& body) const {
        for (Index p = first_points[triangle]; p != kInvalidIndex; p = next_points[p]) body(p);
    }
    void add(Index triangle, Index point) {
        next_points[point] = first_points[triangle];
        first_points[triangle] = point;
    }
    /// Puts the points within `limit` into the chains of their owners; the others are off.
    void link(std::size_t num_triangles, double limit);
};

/// Gives each point to a triangle at the vertex above it, or else to the nearest triangle; ready to
/// be linked. `vertex_points` as in DenseMesh.
Attribution attribute_points(const Surface& surface, std::vector<Vec3d> points,
                             std::span<const Index> vertex_points, const Context& context);

}  // namespace pointbake
