// The surface triangles around each point of the cloud.
#pragma once

#include <vector>

#include "core/adjacency.h"
#include "pointbake/types.h"

namespace pointbake {

/// Several vertices may lie over one point: their triangles count together.
class SurfaceRings {
 public:
    /// Keeps a view of the surface. Throws Error{kInvalidInput} if vertex_points is not one point
    /// per vertex.
    SurfaceRings(const DenseMesh& surface, std::size_t num_points);

    /// Sum of the triangles' normals, weighted by area; zero = no triangle.
    Vec3d outward(Index point) const;

 private:
    const Mesh& mesh_;
    std::vector<Triangle> mapped_;         ///< triangles over points, where vertices are not points
    std::span<const Triangle> triangles_;  ///< triangles over points
    VertexTriangles around_;
};

}  // namespace pointbake
