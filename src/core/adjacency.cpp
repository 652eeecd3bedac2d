#include "core/adjacency.h"

#include <algorithm>
#include <numeric>
#include <tuple>

#include "core/union_find.h"

namespace pointbake {
namespace {

// A triangle's edge k, from corner k to corner k+1, keyed by its vertices in ascending order.
struct HalfEdge {
    Index low, high, triangle;
    std::uint8_t corner;
    bool forward;  // runs from low to high
};

// By the lower vertex, then the higher one, then the triangle: buckets by the lower vertex, sorted
// inside.
std::vector<HalfEdge> sorted_half_edges(std::span<const Triangle> triangles) {
    Index num_vertices = 0;
    for (const Triangle& t : triangles)
        num_vertices = std::max(num_vertices, std::max({t[0], t[1], t[2]}) + 1);
    std::vector<std::size_t> begin(num_vertices + std::size_t{1}, 0);
    const auto low_of = [](const Triangle& t, std::size_t k) {
        return std::min(t[k], t[(k + 1) % 3]);
    };
    for (const Triangle& t : triangles)
        for (std::size_t k = 0; k < 3; ++k) ++begin[low_of(t, k) + std::size_t{1}];
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<HalfEdge> edges(triangles.size() * 3);
    std::vector<std::size_t> next(begin.begin(), begin.end() - 1);
    for (Index t = 0; t < triangles.size(); ++t) {
        for (std::uint8_t k = 0; k < 3; ++k) {
            const Index a = triangles[t][k], b = triangles[t][(k + 1U) % 3U];
            edges[next[std::min(a, b)]++] = {std::min(a, b), std::max(a, b), t, k, a < b};
        }
    }
    for (Index v = 0; v < num_vertices; ++v)
        std::sort(edges.begin() + static_cast<std::ptrdiff_t>(begin[v]),
                  edges.begin() + static_cast<std::ptrdiff_t>(begin[v + std::size_t{1}]),
                  [](const HalfEdge& x, const HalfEdge& y) {
                      return std::tie(x.high, x.triangle, x.corner) <
                             std::tie(y.high, y.triangle, y.corner);
                  });
    return edges;
}

// Calls body(first, last) for every run of half-edges over the same two vertices.
template <class Body>
void for_each_edge(const std::vector<HalfEdge>& edges, Body&& body) {
    for (std::size_t i = 0; i < edges.size();) {
        std::size_t j = i + 1;
        while (j < edges.size() && edges[j].low == edges[i].low && edges[j].high == edges[i].high)
            ++j;
        body(i, j);
        i = j;
    }
}

// Vertices whose triangles form more than one fan: corners are joined across shared edges, then
// counted per vertex.
Index count_nonmanifold_vertices(std::size_t num_vertices, std::span<const Triangle> triangles,
                                 const std::vector<HalfEdge>& edges) {
    UnionFind corners(triangles.size() * 3);
    const auto corner_of = [&](const HalfEdge& e, Index vertex) {
        return e.triangle * 3 +
               (triangles[e.triangle][e.corner] == vertex ? e.corner : (e.corner + 1U) % 3U);
    };
    for_each_edge(edges, [&](std::size_t i, std::size_t j) {
        for (std::size_t k = i + 1; k < j; ++k) {
            corners.unite(corner_of(edges[i], edges[i].low), corner_of(edges[k], edges[i].low));
            corners.unite(corner_of(edges[i], edges[i].high), corner_of(edges[k], edges[i].high));
        }
    });
    std::vector<std::uint8_t> fans(num_vertices, 0);
    for (Index c = 0; c < corners.size(); ++c) {
        std::uint8_t& n = fans[triangles[c / 3][c % 3]];
        if (corners.find(c) == c && n < 2) ++n;
    }
    return static_cast<Index>(std::count(fans.begin(), fans.end(), std::uint8_t{2}));
}

}  // namespace

VertexTriangles vertex_triangles(std::size_t num_vertices, std::span<const Triangle> triangles) {
    VertexTriangles out;
    out.begin.assign(num_vertices + 1, 0);
    for (const Triangle& t : triangles) {
        for (Index v : t) ++out.begin[v + 1];
    }
    std::partial_sum(out.begin.begin(), out.begin.end(), out.begin.begin());
    out.items.resize(triangles.size() * 3);
    std::vector<Index> next(out.begin.begin(), out.begin.end() - 1);
    for (Index t = 0; t < triangles.size(); ++t) {
        for (Index v : triangles[t]) out.items[next[v]++] = t;
    }
    return out;
}

std::vector<std::array<Index, 3>> triangle_neighbors(std::span<const Triangle> triangles) {
    std::vector<std::array<Index, 3>> neighbors(triangles.size(),
                                                {kInvalidIndex, kInvalidIndex, kInvalidIndex});
    const std::vector<HalfEdge> edges = sorted_half_edges(triangles);
    for_each_edge(edges, [&](std::size_t i, std::size_t j) {
        if (j - i != 2 || edges[i].forward == edges[i + 1].forward) return;
        neighbors[edges[i].triangle][edges[i].corner] = edges[i + 1].triangle;
        neighbors[edges[i + 1].triangle][edges[i + 1].corner] = edges[i].triangle;
    });
    return neighbors;
}

Topology topology(std::size_t num_vertices, std::span<const Triangle> triangles) {
    Topology out;
    out.num_triangles = static_cast<Index>(triangles.size());
    const std::vector<HalfEdge> edges = sorted_half_edges(triangles);
    UnionFind all(num_vertices), boundary(num_vertices);
    std::vector<bool> used(num_vertices, false), on_boundary(num_vertices, false);
    for_each_edge(edges, [&](std::size_t i, std::size_t j) {
        ++out.num_edges;
        const Index a = edges[i].low, b = edges[i].high;
        all.unite(a, b);
        used[a] = used[b] = true;
        if (j - i == 1) {
            ++out.num_boundary_edges;
            boundary.unite(a, b);
            on_boundary[a] = on_boundary[b] = true;
        } else if (j - i > 2 || edges[i].forward == edges[i + 1].forward) {
            ++out.num_nonmanifold_edges;
        }
    });
    for (Index v = 0; v < num_vertices; ++v) {
        if (!used[v]) continue;
        ++out.num_vertices;
        out.num_components += all.find(v) == v ? 1 : 0;
        out.num_boundary_loops += on_boundary[v] && boundary.find(v) == v ? 1 : 0;
    }
    out.num_nonmanifold_vertices = count_nonmanifold_vertices(num_vertices, triangles, edges);
    return out;
}

double volume(std::span<const Vec3d> positions, std::span<const Triangle> triangles) {
    if (positions.empty()) return 0.0;
    const Vec3d o = positions.front();
    double six = 0.0;
    for (const Triangle& t : triangles)
        six += dot(positions[t[0]] - o, cross(positions[t[1]] - o, positions[t[2]] - o));
    return six / 6.0;
}

}  // namespace pointbake
