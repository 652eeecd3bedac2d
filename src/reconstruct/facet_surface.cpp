#include "reconstruct/facet_surface.h"

#include <algorithm>

#include "core/adjacency.h"
#include "core/message.h"
#include "core/parallel.h"

namespace pointbake {
namespace {

constexpr std::size_t kGrain = 1U << 12;
// Rounds in which cells around a pinched edge change sides; later ones only fill, which must end.
constexpr int kRelabelRounds = 8, kFillRounds = 32;
// Rounds of new pairs for what is left.
constexpr int kRepairRounds = 16;

struct Edge {
    Index v, w;
};

std::vector<HalfFacet> list_boundary(const Tetrahedra& tets,
                                     const std::vector<std::uint8_t>& inside,
                                     const Context& context) {
    const std::size_t grain = std::size_t{1} << 16;
    std::vector<std::vector<HalfFacet>> parts((tets.cells.size() + grain - 1) / grain);
    parallel_for(context, tets.cells.size(), grain, [&](std::size_t begin, std::size_t end) {
        auto& part = parts[begin / grain];
        for (Index c = static_cast<Index>(begin); c < end; ++c) {
            if (inside[c] == 0) continue;
            for (Index i = 0; i < 4; ++i)
                if (inside[tets.neighbors[c][i]] == 0) part.push_back(c * 4 + i);
        }
    });
    std::vector<HalfFacet> facets;
    for (const auto& part : parts) facets.insert(facets.end(), part.begin(), part.end());
    return facets;
}

std::size_t corner_of(const Triangle& t, Index v) { return t[0] == v ? 0 : (t[1] == v ? 1 : 2); }

// Edges that more than one triangle runs along in the same direction.
std::vector<Edge> crowded_edges(std::size_t num_vertices, const std::vector<Triangle>& triangles,
                                const VertexTriangles& around, const Context& context) {
    const std::size_t grain = kGrain;
    std::vector<std::vector<Edge>> parts((num_vertices + grain - 1) / grain);
    parallel_for(context, num_vertices, grain, [&](std::size_t begin, std::size_t end) {
        std::vector<Index> next, previous;
        for (Index v = static_cast<Index>(begin); v < end; ++v) {
            next.clear(), previous.clear();
            for (Index t : around.of(v)) {
                const std::size_t k = corner_of(triangles[t], v);
                next.push_back(triangles[t][(k + 1) % 3]);
                previous.push_back(triangles[t][(k + 2) % 3]);
            }
            std::sort(next.begin(), next.end());
            std::sort(previous.begin(), previous.end());
            for (const auto* list : {&next, &previous})
                for (std::size_t k = 1; k < list->size(); ++k)
                    if ((*list)[k] == (*list)[k - 1] && v < (*list)[k])
                        parts[begin / grain].push_back({v, (*list)[k]});
        }
    });
    std::vector<Edge> edges;
    for (const auto& part : parts) edges.insert(edges.end(), part.begin(), part.end());
    const auto less = [](Edge a, Edge b) { return a.v != b.v ? a.v < b.v : a.w < b.w; };
    std::sort(edges.begin(), edges.end(), less);
    const auto same = [](Edge a, Edge b) { return a.v == b.v && a.w == b.w; };
    edges.erase(std::unique(edges.begin(), edges.end(), same), edges.end());
    return edges;
}

// Cells around an edge, in order.
std::vector<Index> ring_of(const Tetrahedra& tets, Edge edge) {
    std::vector<Index> ring;
    for (Index c : tets.star(edge.v)) {
        const std::size_t w = tets.slot(c, edge.w);
        if (tets.cells[c][w] != edge.w) continue;
        std::size_t x = 0;
        while (tets.cells[c][x] == edge.v || tets.cells[c][x] == edge.w) ++x;
        std::size_t y = x + 1;
        while (tets.cells[c][y] == edge.v || tets.cells[c][y] == edge.w) ++y;
        Turn turn{c, x, tets.cells[c][y]};
        do {
            ring.push_back(turn.cell);
            turn = next_turn(tets, turn);
        } while (turn.cell != c);
        return ring;
    }
    return ring;
}

// Maximal runs of cells with one label around an edge.
struct Wedge {
    std::size_t first, count;
    bool inside, has_far;
};

std::vector<Wedge> wedges_of(const Tetrahedra& tets, const std::vector<Index>& ring,
                             const std::vector<std::uint8_t>& inside) {
    std::size_t start = 0;
    const std::size_t n = ring.size();
    while (start < n && inside[ring[start]] == inside[ring[(start + n - 1) % n]]) ++start;
    std::vector<Wedge> wedges;
    if (start == n) return wedges;
    for (std::size_t k = 0; k < n; ++k) {
        const Index c = ring[(start + k) % n];
        if (wedges.empty() || (inside[c] != 0) != wedges.back().inside)
            wedges.push_back({start + k, 0, inside[c] != 0, false});
        ++wedges.back().count;
        wedges.back().has_far |= tets.has_far(c);
    }
    return wedges;
}

// Gives the thinnest wedge of a pinched edge the other label. False if nothing may change.
bool relabel_edge(const Tetrahedra& tets, Edge edge, bool only_fill,
                  std::vector<std::uint8_t>& inside) {
    const std::vector<Index> ring = ring_of(tets, edge);
    const std::vector<Wedge> wedges = wedges_of(tets, ring, inside);
    if (wedges.size() <= 2) return false;  // cured by an earlier change
    const Wedge* best = nullptr;
    for (const Wedge& w : wedges) {
        if ((only_fill && w.inside) || (!w.inside && w.has_far)) continue;
        if (best == nullptr || w.count < best->count ||
            (w.count == best->count && best->inside && !w.inside))
            best = &w;
    }
    if (best == nullptr) return false;
    for (std::size_t k = 0; k < best->count; ++k)
        inside[ring[(best->first + k) % ring.size()]] ^= 1;
    return true;
}

void relabel_pinched_edges(const Tetrahedra& tets, std::vector<std::uint8_t>& inside,
                           const Context& context) {
    for (int round = 0; round < kRelabelRounds + kFillRounds; ++round) {
        const auto triangles = triangles_of(tets, list_boundary(tets, inside, context), context);
        const auto around = vertex_triangles(tets.points.size(), triangles);
        bool changed = false;
        for (Edge e : crowded_edges(tets.points.size(), triangles, around, context))
            changed |= relabel_edge(tets, e, round >= kRelabelRounds, inside);
        if (!changed) return;
    }
}

// The facet on the other side of the inner (or outer) wedge that `facet` bounds at its edge.
HalfFacet across(const Tetrahedra& tets, const std::vector<std::uint8_t>& inside, HalfFacet facet,
                 std::size_t edge) {
    Turn turn = first_turn(tets, facet, edge);
    while (inside[tets.neighbors[turn.cell][turn.exit]] != 0) turn = next_turn(tets, turn);
    return turn.cell * 4 + static_cast<Index>(turn.exit);
}

// One vertex per connected fan of facets.
struct Fans {
    std::vector<Triangle> triangles;
    std::vector<Index> vertex_points;
};

// Numbers the fans around each point; the vertices ascend with the points.
Fans number_fans(const Tetrahedra& tets, const FacetSurface& surface,
                 const std::vector<Triangle>& points_of, const VertexTriangles& around,
                 const Context& context) {
    Fans fans;
    fans.triangles.assign(points_of.size(), {});
    std::vector<Index> num_fans(tets.num_real() + std::size_t{1}, 0);
    parallel_for(context, tets.num_real(), kGrain, [&](std::size_t begin, std::size_t end) {
        std::vector<Index> stack;
        for (Index v = static_cast<Index>(begin); v < end; ++v) {
            const auto triangles = around.of(v);
            for (Index t : triangles) fans.triangles[t][corner_of(points_of[t], v)] = kInvalidIndex;
            for (Index seed : triangles) {
                if (fans.triangles[seed][corner_of(points_of[seed], v)] != kInvalidIndex) continue;
                const Index fan = num_fans[v + 1]++;
                stack.assign(1, seed);
                while (!stack.empty()) {
                    const Index t = stack.back();
                    stack.pop_back();
                    const std::size_t k = corner_of(points_of[t], v);
                    if (fans.triangles[t][k] != kInvalidIndex) continue;
                    fans.triangles[t][k] = fan;
                    for (std::size_t edge : {k, (k + 2) % 3})
                        if (surface.mates[t][edge] != kInvalidIndex)
                            stack.push_back(surface.mates[t][edge] / 3);
                }
            }
        }
    });
    for (Index v = 0; v < tets.num_real(); ++v) {
        fans.vertex_points.insert(fans.vertex_points.end(), num_fans[v + 1], v);
        num_fans[v + 1] += num_fans[v];
    }
    for (std::size_t t = 0; t < points_of.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k) fans.triangles[t][k] += num_fans[points_of[t][k]];
    return fans;
}

// Crowded edges of the index mesh. Only points with more than one triangle along an edge can have
// some: most surfaces have none.
std::vector<Edge> find_crowded(const Tetrahedra& tets, const std::vector<Triangle>& points_of,
                               const VertexTriangles& around, const Fans& fans,
                               const Context& context) {
    if (crowded_edges(tets.num_real(), points_of, around, context).empty()) return {};
    const auto around_fans = vertex_triangles(fans.vertex_points.size(), fans.triangles);
    return crowded_edges(fans.vertex_points.size(), fans.triangles, around_fans, context);
}

// Triangle corners (3 * triangle + corner) at which an edge of the index mesh starts, per
// direction.
struct EdgeUse {
    std::vector<Index> forward, backward;
};

std::vector<EdgeUse> uses_of(const std::vector<Edge>& edges, const Fans& fans) {
    const auto around = vertex_triangles(fans.vertex_points.size(), fans.triangles);
    std::vector<EdgeUse> uses;
    for (const Edge& e : edges) {
        EdgeUse& use = uses.emplace_back();
        for (Index t : around.of(e.v)) {
            const auto k = static_cast<Index>(corner_of(fans.triangles[t], e.v));
            if (fans.triangles[t][(k + 1) % 3] == e.w) use.forward.push_back(t * 3 + k);
            if (fans.triangles[t][(k + 2) % 3] == e.w) use.backward.push_back(t * 3 + (k + 2) % 3);
        }
    }
    return uses;
}

// Two pairs at one edge whose fans are the same at both ends: swapping partners (the outer wedges
// instead of the inner ones) parts the fans.
void pair_anew(const std::vector<Edge>& crowded, const Fans& fans, FacetSurface& surface) {
    const auto mate = [&](Index use) -> Index& { return surface.mates[use / 3][use % 3]; };
    for (const EdgeUse& use : uses_of(crowded, fans)) {
        if (use.forward.size() < 2) continue;
        const Index a = use.forward[0], b = use.forward[1];
        std::swap(mate(a), mate(b));
        mate(mate(a)) = a;
        mate(mate(b)) = b;
    }
}

// Keeps one pair of mates per edge (or one triangle) and takes the others away.
void drop_extra(const std::vector<Edge>& crowded, const Fans& fans, FacetSurface& surface) {
    std::vector<std::uint8_t> dropped(surface.facets.size(), 0);
    for (const EdgeUse& use : uses_of(crowded, fans)) {
        Index kept = kInvalidIndex;
        for (Index u : use.forward)
            if (kept == kInvalidIndex && surface.mates[u / 3][u % 3] != kInvalidIndex) kept = u;
        if (kept == kInvalidIndex) kept = use.forward.empty() ? use.backward[0] : use.forward[0];
        const Index partner = surface.mates[kept / 3][kept % 3];
        for (const auto* list : {&use.forward, &use.backward})
            for (Index u : *list)
                if (u != kept && u != partner) dropped[u / 3] = 1;
    }
    drop_facets(dropped, surface);
}

}  // namespace

std::vector<Triangle> triangles_of(const Tetrahedra& tets, std::span<const HalfFacet> facets,
                                   const Context& context) {
    std::vector<Triangle> triangles(facets.size());
    parallel_for(context, facets.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t t = begin; t < end; ++t) triangles[t] = tets.triangle(facets[t]);
    });
    return triangles;
}

void drop_facets(std::span<const std::uint8_t> dropped, FacetSurface& surface) {
    std::vector<Index> renumbered(surface.facets.size(), kInvalidIndex);
    FacetSurface rest;
    for (std::size_t t = 0; t < surface.facets.size(); ++t) {
        if (dropped[t] != 0) continue;
        renumbered[t] = static_cast<Index>(rest.facets.size());
        rest.facets.push_back(surface.facets[t]);
        rest.mates.push_back(surface.mates[t]);
    }
    for (auto& mates : rest.mates)
        for (Index& m : mates)
            if (m != kInvalidIndex)
                m = renumbered[m / 3] == kInvalidIndex ? kInvalidIndex
                                                       : renumbered[m / 3] * 3 + m % 3;
    surface = std::move(rest);
}

void drop_unused_vertices(IndexedSurface& surface) {
    std::vector<Index> renumbered(surface.vertex_points.size(), kInvalidIndex);
    for (const Triangle& t : surface.triangles)
        for (Index v : t) renumbered[v] = 0;
    std::vector<Index> points;
    for (std::size_t v = 0; v < renumbered.size(); ++v) {
        if (renumbered[v] == kInvalidIndex) continue;
        renumbered[v] = static_cast<Index>(points.size());
        points.push_back(surface.vertex_points[v]);
    }
    surface.vertex_points = std::move(points);
    for (Triangle& t : surface.triangles)
        for (Index& v : t) v = renumbered[v];
}

FacetSurface boundary_of(const Tetrahedra& tets, std::vector<std::uint8_t>& inside,
                         const Context& context) {
    relabel_pinched_edges(tets, inside, context);
    FacetSurface surface{list_boundary(tets, inside, context), {}};
    std::vector<Index> first_of(tets.cells.size());  // facet of the surface, if the cell has one
    for (std::size_t t = surface.facets.size(); t-- > 0;)
        first_of[surface.facets[t] / 4] = static_cast<Index>(t);
    // The facets of a cell follow one another.
    const auto number_of = [&](HalfFacet facet) {
        Index t = first_of[facet / 4];
        while (surface.facets[t] != facet) ++t;
        return t;
    };
    surface.mates.resize(surface.facets.size());
    parallel_for(context, surface.facets.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t t = begin; t < end; ++t) {
            const Triangle own = tets.triangle(surface.facets[t]);
            for (std::size_t k = 0; k < 3; ++k) {
                const HalfFacet other = across(tets, inside, surface.facets[t], k);
                const std::size_t start = corner_of(tets.triangle(other), own[(k + 1) % 3]);
                surface.mates[t][k] = number_of(other) * 3 + static_cast<Index>(start);
            }
        }
    });
    return surface;
}

IndexedSurface split_fans(const Tetrahedra& tets, FacetSurface surface, bool is_open,
                          const Context& context) {
    for (int round = 0;; ++round) {
        const auto points_of = triangles_of(tets, surface.facets, context);
        const auto around = vertex_triangles(tets.num_real(), points_of);
        Fans fans = number_fans(tets, surface, points_of, around, context);
        const std::vector<Edge> crowded = find_crowded(tets, points_of, around, fans, context);
        if (crowded.empty()) return {std::move(fans.vertex_points), std::move(fans.triangles)};
        if (!is_open && round == kRepairRounds)
            fail(ErrorCode::kDegenerate,
                 "the watertight surface touches itself along {} edges and cannot be taken apart; "
                 "try --surface open",
                 crowded.size());
        if (is_open)
            drop_extra(crowded, fans, surface);
        else
            pair_anew(crowded, fans, surface);
    }
}

}  // namespace pointbake
