// Based on [Dey03]: points with a whole umbrella split the cells around them in two sides.
// Departures: the umbrellas are of the walked surface, in which slivers are resolved; points joined
// by facets form patches, and which side of a patch is out follows from all the evidence there is,
// strongest first, so that one bad point flips nothing; cells that the points leave open, or
// disagree on, are not peeled one by one but labelled by a minimum cut (as [Labatut09] do with
// other votes), which adds the least area; cavities inside stay; pieces too small to be anything
// but a slip are dropped.
#include "reconstruct/tight_cocone.h"

#include <algorithm>
#include <functional>
#include <set>

#include "core/adjacency.h"
#include "core/parallel.h"
#include "reconstruct/min_cut.h"

namespace pointbake {
namespace {

constexpr double kFoldedCos = -0.9;  // facets folded onto each other at an edge
// Pieces with fewer facets are slips: a tetrahedron has 4, a cube of two triangles a side 12.
constexpr Index kMinFacets = 12;
// Cut costs in integers: of a facet as large as the squared spacing, and the largest.
constexpr std::int64_t kUnitCost = 64, kMaxCost = 1 << 20;
// A facet that Cocone had among its candidates costs this share.
constexpr double kAgreedFactor = 0.1;
// Circumradius in spacings: how far it may lower or raise a facet's cost.
constexpr double kMinReach = 0.25, kMaxReach = 4.0;
// Votes that settle a cell if none is against: a single point may err.
constexpr int kMinVotes = 2;
constexpr std::size_t kGrain = 1U << 11;
constexpr std::size_t kPollInterval = 1U << 16;

class Labeller {
 public:
    Labeller(const Tetrahedra& tets, const Cocone& cocone, const FacetSurface& surface,
             const Context& context)
        : tets_(tets),
          cocone_(cocone),
          surface_(surface),
          context_(context),
          wall_(tets.cells.size() * 4, 0),
          triangles_(triangles_of(tets, surface.facets, context)),
          around_(vertex_triangles(tets.num_real(), triangles_)) {
        for (HalfFacet f : surface.facets) wall_[f] = wall_[tets.mirror(f)] = 1;
    }

    InsideLabels run() {
        find_good();
        split_stars();
        find_patches();
        orient_patches();
        settle();
        return finish();
    }

 private:
    // Which way round the two sides of a patch are.
    enum Orientation : std::int8_t { kUnknown = 0, kFirstIsOut = 1, kFirstIsIn = -1 };

    // The surface facets at v: the edge opposite v, and the facet.
    struct Spoke {
        Index from, to;
        HalfFacet facet;
    };

    void spokes_at(Index v, std::vector<Spoke>& spokes) const {
        spokes.clear();
        for (Index number : around_.of(v)) {
            const Triangle& t = triangles_[number];
            const std::size_t k = t[0] == v ? 0 : (t[1] == v ? 1 : 2);
            spokes.push_back({t[(k + 1) % 3], t[(k + 2) % 3], surface_.facets[number]});
        }
    }

    // One closed disc: the edges opposite v form a single cycle.
    bool is_disc(Index v, std::vector<Spoke>& spokes) const {
        spokes_at(v, spokes);
        if (spokes.size() < 3) return false;
        Index at = spokes[0].to;
        std::size_t last = 0;
        for (std::size_t length = 1; length <= spokes.size(); ++length) {
            std::size_t next = spokes.size(), num_next = 0;
            for (std::size_t k = 0; k < spokes.size(); ++k) {
                if (k == last || (spokes[k].from != at && spokes[k].to != at)) continue;
                next = k, ++num_next;
            }
            if (num_next != 1 || is_folded(v, at, spokes[last].facet, spokes[next].facet))
                return false;
            if (next == 0) return length == spokes.size();
            at = spokes[next].from == at ? spokes[next].to : spokes[next].from;
            last = next;
        }
        return false;
    }

    // Two facets at the edge (v, w) that nearly lie on each other, or, where v is not flat, that
    // form a sharp fold.
    bool is_folded(Index v, Index w, HalfFacet f, HalfFacet g) const {
        const Vec3d axis = tets_.points[w] - tets_.points[v];
        const auto normal = [&](HalfFacet facet) {
            const Triangle t = tets_.triangle(facet);
            const Index third =
                t[0] != v && t[0] != w ? t[0] : (t[1] != v && t[1] != w ? t[1] : t[2]);
            return cross(axis, tets_.points[third] - tets_.points[v]);
        };
        // The two third vertices lie on opposite sides of the edge: opposite normals are flat.
        const Vec3d a = normal(f), b = -normal(g);
        const double c = dot(a, b), scale = std::sqrt(squared_length(a) * squared_length(b));
        return c <= kFoldedCos * scale || (c < 0 && cocone_.flat[v] == 0);
    }

    void find_good() {
        good_.assign(tets_.num_real(), 0);
        parallel_for(context_, tets_.num_real(), kGrain, [&](std::size_t begin, std::size_t end) {
            std::vector<Spoke> spokes;
            for (Index v = static_cast<Index>(begin); v < end; ++v)
                good_[v] = is_disc(v, spokes) ? 1 : 0;
        });
        num_poor_ = static_cast<Index>(std::count(good_.begin(), good_.end(), 0));
    }

    // Every good vertex's disc parts the cells around it: +1 where the first cell of its star lies,
    // -1 beyond.
    void split_stars() {
        sides_.assign(tets_.cells.size() * 4, 0);
        parallel_for(context_, tets_.num_real(), kGrain, [&](std::size_t begin, std::size_t end) {
            std::vector<Index> stack;
            for (Index v = static_cast<Index>(begin); v < end; ++v)
                if (good_[v] != 0) split_star(v, stack);
        });
    }

    std::int8_t& side(Index cell, Index vertex) {
        return sides_[cell * 4 + tets_.slot(cell, vertex)];
    }

    void split_star(Index v, std::vector<Index>& stack) {
        const auto star = tets_.star(v);
        for (Index c : star) side(c, v) = -1;
        stack.assign(1, star[0]);
        side(star[0], v) = 1;
        while (!stack.empty()) {
            const Index c = stack.back();
            stack.pop_back();
            for (Index i = 0; i < 4; ++i) {
                if (tets_.cells[c][i] == v || wall_[c * 4 + i] != 0) continue;
                const Index n = tets_.neighbors[c][i];
                if (side(n, v) > 0) continue;
                side(n, v) = 1;
                stack.push_back(n);
            }
        }
    }

    // Good vertices joined by facets form patches, in each of which the sides agree after some are
    // exchanged.
    void find_patches() {
        patch_of_.assign(tets_.num_real(), kInvalidIndex);
        std::vector<Index> queue;
        for (Index first = 0; first < tets_.num_real(); ++first) {
            if (good_[first] == 0 || patch_of_[first] != kInvalidIndex) continue;
            const auto patch = static_cast<Index>(patch_members_.size());
            patch_of_[first] = patch;
            queue.assign(1, first);
            for (std::size_t head = 0; head < queue.size(); ++head) {
                const Index v = queue[head];
                for (Index t : around_.of(v))
                    for (Index u : triangles_[t])
                        if (good_[u] != 0 && patch_of_[u] == kInvalidIndex) {
                            align(u, v, surface_.facets[t] / 4);
                            patch_of_[u] = patch;
                            queue.push_back(u);
                        }
            }
            patch_members_.push_back(queue);
        }
    }

    // Exchanges u's sides if a cell at both is on different ones.
    void align(Index u, Index v, Index cell) {
        if (side(cell, u) == side(cell, v)) return;
        for (Index c : tets_.star(u)) side(c, u) = static_cast<std::int8_t>(-side(c, u));
    }

    // How often the labels that two patches give to common cells agree, less how often they do not,
    // if both call their first side out.
    struct Link {
        Index from, to;
        std::int64_t weight;
    };

    std::vector<Link> find_links() const {
        if (patch_members_.size() < 2) return {};
        std::vector<Link> all;
        for (Index c = 0; c < tets_.num_cells(); ++c) {
            for (Index i = 0; i < 4; ++i) {
                for (Index j = 0; j < 4; ++j) {
                    const int agree = sides_[c * 4 + i] * sides_[c * 4 + j];
                    if (agree == 0) continue;
                    const Index p = patch_of_[tets_.cells[c][i]], q = patch_of_[tets_.cells[c][j]];
                    if (p != q) all.push_back({p, q, agree});
                }
            }
        }
        std::sort(all.begin(), all.end(), [](const Link& a, const Link& b) {
            return a.from != b.from ? a.from < b.from : a.to < b.to;
        });
        std::vector<Link> links;
        for (const Link& l : all) {
            if (!links.empty() && links.back().from == l.from && links.back().to == l.to)
                links.back().weight += l.weight;
            else
                links.push_back(l);
        }
        return links;
    }

    // What the far points say of a patch: the side that sees more of them is out.
    std::int64_t far_score(Index patch) {
        std::int64_t sum = 0;
        for (Index v : patch_members_[patch])
            for (Index c : tets_.star(v))
                if (tets_.has_far(c)) sum += side(c, v);
        return sum;
    }

    // The patch with the strongest evidence comes first; its neighbours learn from it.
    void orient_patches() {
        const auto num_patches = static_cast<Index>(patch_members_.size());
        const std::vector<Link> links = find_links();
        std::vector<std::int64_t> score(num_patches);
        std::set<std::pair<std::int64_t, Index>> queue;
        orientation_.assign(num_patches, kUnknown);
        for (Index p = 0; p < num_patches; ++p) {
            score[p] = far_score(p);
            if (score[p] != 0) queue.emplace(-std::abs(score[p]), p);
        }
        while (!queue.empty()) {
            const Index p = queue.begin()->second;
            queue.erase(queue.begin());
            orientation_[p] = score[p] > 0 ? kFirstIsOut : kFirstIsIn;
            auto link = std::lower_bound(links.begin(), links.end(), p,
                                         [](const Link& l, Index q) { return l.from < q; });
            for (; link != links.end() && link->from == p; ++link) {
                const Index q = link->to;
                if (orientation_[q] != kUnknown) continue;
                queue.erase({-std::abs(score[q]), q});
                score[q] += orientation_[p] * link->weight;
                if (score[q] != 0) queue.emplace(-std::abs(score[q]), q);
            }
        }
    }

    // Votes of a cell's good vertices whose patch has a side: positive = out.
    struct Votes {
        int out = 0, in = 0;
    };
    Votes votes_of(Index cell) const {
        Votes votes;
        for (Index i = 0; i < 4; ++i) {
            const std::int8_t s = sides_[cell * 4 + i];
            if (s == 0) continue;
            const int vote = s * orientation_[patch_of_[tets_.cells[cell][i]]];
            votes.out += vote > 0 ? 1 : 0;
            votes.in += vote < 0 ? 1 : 0;
        }
        return votes;
    }

    enum class Side : std::uint8_t { kOpen, kOut, kIn };

    // Cells whose votes are unanimous have a side.
    Side settled_side(Index cell) const {
        if (tets_.has_far(cell)) return Side::kOut;
        const Votes votes = votes_of(cell);
        if (votes.out >= kMinVotes && votes.in == 0) return Side::kOut;
        if (votes.in >= kMinVotes && votes.out == 0) return Side::kIn;
        return Side::kOpen;
    }

    // What it costs to have this facet in the surface: its area in units of the local spacing, more
    // where its points lie far apart, next to nothing where Cocone found it.
    std::int64_t facet_cost(HalfFacet facet) const {
        if (wall_[facet] != 0) return 1;
        double spacing2 = 0.0;
        for (Index v : tets_.triangle(facet)) {
            if (tets_.is_far(v)) return kMaxCost;
            spacing2 = std::max(spacing2, double{cocone_.spacing[v]} * cocone_.spacing[v]);
        }
        if (spacing2 <= 0) return kMaxCost;  // below what a float holds
        const double reach = std::sqrt(circumradius2(tets_, facet) / spacing2);
        const double area = length(tets_.area_vector(facet)) / spacing2;
        const double factor = cocone_.facets[facet] != 0 ? kAgreedFactor : 1.0;
        const double cost = kUnitCost * factor * area * std::clamp(reach, kMinReach, kMaxReach);
        return 1 + static_cast<std::int64_t>(std::min(cost, double{kMaxCost}));
    }

    // The open cells get the labels that cost least: a minimum cut between the settled ones.
    void settle() {
        const Index n = tets_.num_cells();
        std::vector<Index> nodes, node_of(n, kInvalidIndex);
        std::vector<Side> sides(n);
        parallel_for(context_, n, kGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t c = begin; c < end; ++c)
                sides[c] = settled_side(static_cast<Index>(c));
        });
        for (Index c = 0; c < n; ++c) {
            if (sides[c] != Side::kOpen) continue;
            node_of[c] = static_cast<Index>(nodes.size());
            nodes.push_back(c);
        }
        MinCut cut(nodes.size());
        for (Index c : nodes) {
            const Votes votes = votes_of(c);
            cut.add_terminal(node_of[c], kUnitCost * (votes.out - votes.in));
            for (Index i = 0; i < 4; ++i) {
                const Index other = tets_.neighbors[c][i];
                const std::int64_t cost = facet_cost(c * 4 + i);
                if (sides[other] == Side::kOpen) {
                    if (other > c) cut.add_edge(node_of[c], node_of[other], cost);
                } else {
                    cut.add_terminal(node_of[c], sides[other] == Side::kOut ? cost : -cost);
                }
            }
        }
        cut.solve(context_);
        outside_.resize(n);
        for (Index c = 0; c < n; ++c)
            outside_[c] =
                sides[c] == Side::kOut || (sides[c] == Side::kOpen && cut.is_source(node_of[c]));
    }

    // Connected pieces of inside cells, and of outside ones that no far point is part of, take the
    // other label if they are too small or bounded by facets that are not of the surface.
    void drop_slips() {
        const Index n = tets_.num_cells();
        std::vector<std::uint8_t> seen(n, 0);
        std::vector<Index> piece;
        for (Index first = 0; first < n; ++first) {
            if (seen[first] != 0) continue;
            const std::uint8_t label = outside_[first];
            bool has_far = false;
            Index num_facets = 0, num_walls = 0;
            piece.assign(1, first);
            seen[first] = 1;
            for (std::size_t head = 0; head < piece.size(); ++head) {
                const Index c = piece[head];
                has_far |= tets_.has_far(c);
                for (Index i = 0; i < 4; ++i) {
                    const Index other = tets_.neighbors[c][i];
                    if (other == kInvalidIndex) continue;
                    if (outside_[other] != label) {
                        ++num_facets;
                        num_walls += wall_[c * 4 + i];
                    } else if (seen[other] == 0) {
                        seen[other] = 1;
                        piece.push_back(other);
                    }
                }
            }
            if (has_far || (num_facets >= kMinFacets && num_walls * 2 >= num_facets)) continue;
            for (Index c : piece) outside_[c] = label ^ 1;
        }
    }

    InsideLabels finish() {
        drop_slips();
        InsideLabels labels;
        labels.num_poor = num_poor_;
        labels.num_conflicts = parallel_reduce(
            context_, tets_.num_cells(), kGrain, Index{0},
            [&](std::size_t begin, std::size_t end) {
                Index n = 0;
                for (Index c = static_cast<Index>(begin); c < end; ++c) {
                    const Votes votes = votes_of(c);
                    n += votes.in > 0 && votes.out > 0 ? 1 : 0;
                }
                return n;
            },
            std::plus<>());
        labels.inside = std::move(outside_);
        for (std::uint8_t& label : labels.inside) label ^= 1;
        return labels;
    }

    const Tetrahedra& tets_;
    const Cocone& cocone_;
    const FacetSurface& surface_;
    const Context& context_;
    std::vector<std::uint8_t> wall_;   // per half facet: part of the surface
    std::vector<Triangle> triangles_;  // of the surface
    VertexTriangles around_;
    std::vector<std::uint8_t> good_, outside_;
    std::vector<std::int8_t> sides_;  // per cell and vertex: side of the vertex's disc, 0 = none
    std::vector<Index> patch_of_;
    std::vector<std::vector<Index>> patch_members_;
    std::vector<Orientation> orientation_;
    Index num_poor_ = 0;
};

}  // namespace

InsideLabels label_cells(const Tetrahedra& tets, const Cocone& cocone, const FacetSurface& surface,
                         const Context& context) {
    return Labeller(tets, cocone, surface, context).run();
}

}  // namespace pointbake
