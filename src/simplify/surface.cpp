#include "simplify/surface.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "core/parallel.h"

namespace pointbake {
namespace {

constexpr std::size_t kVertexGrain = 4096;

void use_edge(std::vector<EdgeUse>& edges, Index neighbor, bool out) {
    auto it = std::find_if(edges.begin(), edges.end(),
                           [&](const EdgeUse& e) { return e.neighbor == neighbor; });
    if (it == edges.end()) it = edges.insert(edges.end(), EdgeUse{neighbor});
    std::uint8_t& count = out ? it->num_out : it->num_in;
    if (count < std::numeric_limits<std::uint8_t>::max()) ++count;
}

std::size_t find_edge(const std::vector<EdgeUse>& edges, Index neighbor) {
    std::size_t i = 0;
    while (edges[i].neighbor != neighbor) ++i;
    return i;
}

// Number of fans around the vertex of `edges` when triangles are joined across regular edges only.
// A fan that is open has one triangle more than joins; a closed one has as many.
std::size_t count_fans(const Surface& surface, Index vertex, const std::vector<EdgeUse>& edges) {
    std::vector<std::size_t> group(edges.size());
    std::iota(group.begin(), group.end(), std::size_t{0});
    const auto root = [&](std::size_t i) {
        while (group[i] != i) i = group[i];
        return i;
    };
    // Regular edges in a row form a group. A triangle between two edges of one group that are
    // already joined closes the ring.
    std::size_t num_triangles = 0, num_regular = 0, num_closed = 0;
    surface.for_each_corner(vertex, [&](Index c) {
        ++num_triangles;
        const std::size_t i = find_edge(edges, surface.after(c)),
                          j = find_edge(edges, surface.before(c));
        if (edges[i].is_special() || edges[j].is_special()) return;
        const std::size_t ri = root(i), rj = root(j);
        num_closed += ri == rj ? 1 : 0;
        group[std::max(ri, rj)] = std::min(ri, rj);
    });
    for (const EdgeUse& e : edges) num_regular += e.is_special() ? 0 : 1;
    return num_triangles - num_regular + num_closed;
}

VertexKind kind_of(const Surface& surface, Index vertex, std::vector<EdgeUse>& edges) {
    collect_edges(surface, vertex, edges);
    std::size_t num_special = 0;
    int degree = 0;
    bool alike = true;
    for (const EdgeUse& e : edges) {
        if (!e.is_special()) continue;
        ++num_special;
        alike = alike && (degree == 0 || degree == e.num_triangles());
        degree = e.num_triangles();
    }
    if (edges.empty() || (num_special != 0 && num_special != 2) || !alike)
        return VertexKind::kFixed;
    const std::size_t expected = num_special == 0 ? 1 : static_cast<std::size_t>(degree);
    if (count_fans(surface, vertex, edges) != expected) return VertexKind::kFixed;
    return num_special == 0 ? VertexKind::kInterior : VertexKind::kCurve;
}

}  // namespace

void collect_edges(const Surface& surface, Index vertex, std::vector<EdgeUse>& out) {
    out.clear();
    surface.for_each_corner(vertex, [&](Index c) {
        use_edge(out, surface.after(c), true);
        use_edge(out, surface.before(c), false);
    });
}

double triangle_area(const Surface& surface, Index triangle) {
    const auto [a, b, c] = surface.corners_of(triangle);
    return 0.5 * length(cross(b - a, c - a));
}

Surface::Surface(std::vector<Vec3d> vertex_positions, const std::vector<Triangle>& all,
                 const Context& context)
    : positions(std::move(vertex_positions)), first_corners(positions.size(), kInvalidIndex) {
    triangles.reserve(all.size());
    for (const Triangle& t : all) {
        if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) triangles.push_back(t);
    }
    num_triangles = static_cast<Index>(triangles.size());
    next_corners.resize(triangles.size() * 3);
    // Backwards, so that every chain ascends.
    for (Index c = static_cast<Index>(next_corners.size()); c-- > 0;) {
        Index& first = first_corners[triangles[c / 3][c % 3]];
        next_corners[c] = first;
        first = c;
    }
    kinds.resize(positions.size());
    parallel_for(context, positions.size(), kVertexGrain, [&](std::size_t begin, std::size_t end) {
        std::vector<EdgeUse> edges;
        for (std::size_t v = begin; v < end; ++v)
            kinds[v] = kind_of(*this, static_cast<Index>(v), edges);
    });
}

void Surface::unlink(Index corner, Index vertex) {
    Index* link = &first_corners[vertex];
    while (*link != corner) link = &next_corners[*link];
    *link = next_corners[corner];
}

void Surface::remove(Index triangle) {
    for (Index k = 0; k < 3; ++k) unlink(3 * triangle + k, triangles[triangle][k]);
    triangles[triangle] = {kInvalidIndex, kInvalidIndex, kInvalidIndex};
    --num_triangles;
}

void Surface::collapse(Index a, Index b, Vec3d target) {
    Index c = first_corners[b];
    while (c != kInvalidIndex) {
        const Index next = next_corners[c], t = c / 3;
        Triangle& v = triangles[t];
        if (v[0] == a || v[1] == a || v[2] == a) {
            for (Index k = 0; k < 3; ++k) {
                if (v[k] != b) unlink(3 * t + k, v[k]);
            }
            v = {kInvalidIndex, kInvalidIndex, kInvalidIndex};
        } else {
            v[c % 3] = a;
            next_corners[c] = first_corners[a];
            first_corners[a] = c;
        }
        c = next;
    }
    first_corners[b] = kInvalidIndex;
    positions[a] = target;
    kinds[a] = std::max(kinds[a], kinds[b]);
}

}  // namespace pointbake
