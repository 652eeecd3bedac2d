// A sparse, adaptive grid of tetrahedra without hanging nodes.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/parallel.h"
#include "pointbake/types.h"

namespace pointbake {

/// Cubes of six tetrahedra each, bisected at their longest edges [Maubach95]. A node is a corner of
/// a cube or the midpoint of such an edge, whose tetrahedra are all split there. That asks for the
/// nodes that brought the tetrahedra about [Gregorski02]: closed under this, the set of nodes is
/// the whole state, and in whatever order it came about, the grid is the same.
class SimplexGrid {
 public:
    using Point = std::array<std::int32_t, 3>;  ///< in units above the corner

    /// `num_cubes` cubes of edge `cube_size` from `corner` on, at most 7 a side.
    SimplexGrid(Vec3d corner, double cube_size, std::array<int, 3> num_cubes);

    static constexpr int kDepth = 17;
    static constexpr std::int32_t kCubeUnits = 1 << kDepth;  ///< a cube's edge

    double cube_size() const { return unit_ * kCubeUnits; }

    /// The vertices of the tetrahedra, numbered as they came. The cubes' corners come first.
    Index num_nodes() const { return static_cast<Index>(points_.size()); }
    bool is_corner(Index node) const { return node < num_corners_; }
    const Point& point(Index node) const { return points_[node]; }
    Vec3d place(const Point& point) const;
    Vec3d place(Index node) const { return place(points_[node]); }
    bool is_on_boundary(Index node) const;

    // Of points that are no corner of a cube:
    /// The ends of the edge whose midpoint it is; kInvalidIndex where they are no nodes.
    std::array<Index, 2> edge(const Point& point) const;
    double edge_length(const Point& point) const;
    /// Radius of the ball around the point that holds the tetrahedra around its edge.
    double reach(const Point& point) const;
    /// How far the tetrahedra around the edge reach from the point along a direction, which need
    /// not be of unit length.
    double reach(const Point& point, Vec3f direction) const;
    int level(
        Index node) const;  ///< bisections from a cube to here; above those of the edge's ends

    /// The node at a point, kInvalidIndex if there is none.
    Index find(const Point& point) const { return table_[slot_of(key_of(point))].node; }
    /// Makes an edge's midpoint a node, and those that it needs.
    void split(const Point& point);
    /// Calls visit(point) for the midpoints of the edges that came with a node, nodes or not; most
    /// come with several nodes and are visited once. The ends of the edges are nodes.
    template <class Visit>
    void for_each_child(Index node, Visit&& visit) const;

    /// The tetrahedra of the grid for which keep(vertices) is true, in an order of their places;
    /// either orientation.
    template <class Keep>
    std::vector<std::array<Index, 4>> leaves(const Context& context, Keep&& keep) const;
    /// Six times the signed volume, in units; positive if (b - a) . ((c - a) x (d - a)) is.
    std::int64_t orientation(const std::array<Index, 4>& tetrahedron) const;

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
    struct Slot {
        std::uint64_t key = 0;  ///< of the node's point
        Index node = kInvalidIndex;
    };

    static Shape shape(const Point& p);
    static Point edge_end(const Point& p, bool is_odd);
    static std::pair<Tet, Tet> halves(const Tet& tet, Index middle);
    static Point moved(Point p, std::size_t axis, std::int32_t by) {
        p[axis] += by;
        return p;
    }
    static std::uint64_t key_of(const Point& p) {
        const auto bits = [](std::int32_t v) { return static_cast<std::uint64_t>(v); };
        return bits(p[0]) | bits(p[1]) << 21 | bits(p[2]) << 42;
    }
    bool is_inside(const Point& p) const;
    bool is_left_to(const Point& child, const Point& parent) const;
    static std::size_t home_of(std::uint64_t key);
    std::size_t slot_of(std::uint64_t key) const;
    bool add(const Point& p);
    void grow_table();
    template <class Visit>
    void for_each_parent(const Point& p, Visit&& visit) const;
    Index midpoint(const Tet& tet) const;
    std::vector<Tet> subtrees() const;
    template <class Keep>
    void descend(const Tet& tet, Keep&& keep, std::vector<std::array<Index, 4>>& out) const;

    Vec3d corner_;
    double unit_;
    std::array<int, 3> num_cubes_;
    Index num_corners_ = 0;
    std::vector<Point> points_;
    std::vector<Slot> table_;  ///< nodes by hash, open addressing
};

template <class Visit>
void SimplexGrid::for_each_child(Index node, Visit&& visit) const {
    const Point p = points_[node];
    const auto visit_inside = [&](const Point& q) {
        if (is_inside(q) && !is_left_to(q, p)) visit(q);
    };
    const auto visit_octants = [&](std::int32_t by) {
        for (const std::int32_t x : {-by, by})
            for (const std::int32_t y : {-by, by})
                for (const std::int32_t z : {-by, by}) visit_inside({p[0] + x, p[1] + y, p[2] + z});
    };
    if (is_corner(node)) return visit_octants(kCubeUnits / 2);
    const Shape s = shape(p);
    if (s.kind == kEdge) {
        if (s.half > 1) visit_octants(s.half / 2);
        return;
    }
    for (std::size_t k = 0; k < 3; ++k) {
        if (s.kind == kFace && k == s.axis) continue;
        visit_inside(moved(p, k, -s.half));
        visit_inside(moved(p, k, s.half));
    }
}

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
