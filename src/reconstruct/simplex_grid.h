// A sparse, adaptive grid of tetrahedra without hanging nodes.
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/parallel.h"
#include "pointbake/types.h"

namespace pointbake {

/// Cubes of six tetrahedra each, bisected at their longest edges [Maubach95]. A node is the
/// midpoint of such an edge; the tetrahedra around the edge are split together, by making the node
/// a vertex. That asks for the nodes that brought the tetrahedra about [DeFloriani04]: closed under
/// this, the set of vertices is the whole state, and in whatever order it came about, the grid is
/// the same.
class SimplexGrid {
 public:
    using Point = std::array<std::int32_t, 3>;  ///< in units above the corner

    /// `num_cubes` cubes of edge `cube_size` from `corner` on, at most 2^(20 - kDepth) a side.
    SimplexGrid(Vec3d corner, double cube_size, std::array<int, 3> num_cubes);

    static constexpr int kDepth = 17;  ///< a cube's edge is 2^kDepth units long

    /// Vertices and candidates for vertices; numbered as they came.
    Index num_nodes() const { return static_cast<Index>(points_.size()); }
    bool is_vertex(Index node) const { return is_vertex_[node] != 0; }
    const Point& point(Index node) const { return points_[node]; }
    Vec3d place(Index node) const;
    bool is_on_boundary(Index node) const;
    bool is_corner(Index node) const { return node < num_corners_; }

    // Of nodes that are no corner of a cube:
    std::array<Index, 2> edge(Index node) const;  ///< whose midpoint it is; vertices
    double edge_length(Index node) const;
    /// Radius of the ball around the node that holds the tetrahedra around its edge.
    double reach(Index node) const;
    int level(
        Index node) const;  ///< bisections from a cube to here; above those of the edge's ends

    /// Makes a node a vertex, and those it needs. New nodes, vertices or candidates, come behind
    /// the old ones.
    void split(Index node);

    /// The tetrahedra of the grid for which keep(vertices) is true, in an order of their places;
    /// either orientation.
    template <class Keep>
    std::vector<std::array<Index, 4>> leaves(const Context& context, Keep&& keep) const;
    /// Six times the signed volume, in units; positive if (b - a) . ((c - a) x (d - a)) is.
    std::int64_t orientation(const std::array<Index, 4>& t) const;

 private:
    enum Kind { kCube, kFace, kEdge };  ///< whose midpoint a node is: odd coordinates tell
    struct Shape {
        Kind kind;
        std::int32_t half;  ///< of the edge length of the cube, face or edge
        std::size_t axis;   ///< along the edge, across the face
    };
    struct Tet {
        std::array<Index, 4> v;
        std::size_t tag;  ///< its longest edge is v[0] to v[tag]
    };
    static Shape shape(const Point& p);
    bool is_inside(const Point& p) const;
    Index find(const Point& p) const;
    Index find_or_add(const Point& p);
    void grow_table();
    template <class Visit>
    void for_each_parent(const Point& p, Visit&& visit) const;
    template <class Visit>
    void for_each_child(const Point& p, Visit&& visit) const;
    Point edge_end(const Point& p, bool is_odd) const;
    Index midpoint(const Tet& tet) const;
    static std::pair<Tet, Tet> halves(const Tet& tet, Index middle);
    std::vector<Tet> subtrees() const;
    template <class Keep>
    void descend(const Tet& tet, Keep&& keep, std::vector<std::array<Index, 4>>& out) const;

    Vec3d corner_;
    double unit_;
    std::array<int, 3> num_cubes_;
    Index num_corners_ = 0;
    std::vector<Point> points_;
    std::vector<std::uint8_t> is_vertex_;
    std::vector<Index> table_;  ///< nodes by hash, open addressing
};

template <class Keep>
void SimplexGrid::descend(const Tet& tet, Keep&& keep,
                          std::vector<std::array<Index, 4>>& out) const {
    const Index middle = midpoint(tet);
    if (middle == kInvalidIndex) {
        if (keep(tet.v)) out.push_back(tet.v);
        return;
    }
    const auto [a, b] = halves(tet, middle);
    descend(a, keep, out);
    descend(b, keep, out);
}

template <class Keep>
std::vector<std::array<Index, 4>> SimplexGrid::leaves(const Context& context, Keep&& keep) const {
    using Leaves = std::vector<std::array<Index, 4>>;
    const std::vector<Tet> roots = subtrees();
    std::vector<Leaves> parts(roots.size());
    parallel_for(context, roots.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) descend(roots[i], keep, parts[i]);
    });
    Leaves all;
    std::size_t count = 0;
    for (const Leaves& part : parts) count += part.size();
    all.reserve(count);
    for (const Leaves& part : parts) all.insert(all.end(), part.begin(), part.end());
    return all;
}

}  // namespace pointbake
