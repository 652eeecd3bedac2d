// Who touches whom in a triangle mesh.
#pragma once

#include <span>
#include <vector>

#include "pointbake/types.h"

namespace pointbake {

/// Triangles around each vertex, in ascending order: those of v are items[begin[v]] ..
/// items[begin[v + 1] - 1].
struct VertexTriangles {
    std::vector<Index> begin, items;
    std::span<const Index> of(Index v) const {
        return std::span(items).subspan(begin[v], begin[v + 1] - begin[v]);
    }
};
VertexTriangles vertex_triangles(std::size_t num_vertices, std::span<const Triangle> triangles);

/// Per triangle, the neighbour across edge k (from corner k to corner k+1), if exactly two
/// triangles share that edge with opposite directions; else kInvalidIndex.
std::vector<std::array<Index, 3>> triangle_neighbors(std::span<const Triangle> triangles);

/// Counts that tell what a surface is.
struct Topology {
    Index num_vertices = 0;  ///< used by a triangle
    Index num_edges = 0, num_triangles = 0;
    Index num_boundary_edges = 0;        ///< one triangle
    Index num_nonmanifold_edges = 0;     ///< more than two, or two of the same direction
    Index num_nonmanifold_vertices = 0;  ///< more than one fan
    Index num_boundary_loops = 0, num_components = 0;
    std::int64_t euler() const { return std::int64_t{num_vertices} - num_edges + num_triangles; }
    bool is_closed_manifold() const {
        return num_boundary_edges + num_nonmanifold_edges + num_nonmanifold_vertices == 0;
    }
};
Topology topology(std::size_t num_vertices, std::span<const Triangle> triangles);

/// Signed volume of a closed, oriented mesh.
double volume(std::span<const Vec3d> positions, std::span<const Triangle> triangles);

}  // namespace pointbake
