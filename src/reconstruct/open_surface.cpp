// Based on [Amenta02]: pruning and manifold extraction by walking on one side of the candidate
// facets. Departure: pruning asks per point whether a closed umbrella is left, in rounds over a
// frozen copy, so that no order matters.
#include "reconstruct/open_surface.h"

#include <algorithm>
#include <deque>
#include <numeric>
#include <span>

#include "core/adjacency.h"
#include "core/parallel.h"
#include "reconstruct/pieces.h"

namespace pointbake {
namespace {

// Largest circumradius of a facet in spacings: wider ones span holes. Facets without a flat point
// have less to show for themselves.
constexpr double kReach = 3.0, kAgreedReach = 1.2;
// An umbrella of a clean cloud that keeps this near to the tangent plane is of one sheet, in
// spacings.
constexpr double kFlatHeight = 0.05;
constexpr std::size_t kGrain = 1U << 11;
constexpr std::size_t kPollInterval = 1U << 16;

enum State : std::uint8_t { kNone = 0, kCandidate = 1, kKept = 2 };

class Walker {
 public:
    Walker(const Tetrahedra& tets, const Cocone& cocone, bool is_noisy, const Context& context)
        : tets_(tets),
          spacing_(cocone.spacing),
          normals_(cocone.normals),
          is_noisy_(is_noisy),
          context_(context),
          state_(tets.cells.size() * 4, kNone) {
        parallel_for(context, state_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
            for (HalfFacet f = static_cast<HalfFacet>(begin); f < end; ++f)
                state_[f] = is_candidate(cocone, f) ? kCandidate : kNone;
        });
    }

    FacetSurface run() {
        prune();
        number_.assign(state_.size(), kInvalidIndex);
        // Pieces start at cells with room around them: inside a sliver all sides are candidates.
        for (int max_candidates = 1; max_candidates <= 4; ++max_candidates)
            for (HalfFacet f = 0; f < state_.size(); ++f)
                if (state_[f] == kCandidate && num_candidates(f / 4) <= max_candidates)
                    walk_from(f);
        return keep_large_pieces();
    }

 private:
    struct Spoke {
        Index from, to;
        HalfFacet facet;
        bool alive;
    };

    // Each seen from one side.
    struct Candidates {
        std::vector<HalfFacet> facets;
        std::vector<Triangle> triangles;
        VertexTriangles around;
    };

    Candidates list_candidates() const {
        Candidates candidates;
        for (HalfFacet f = 0; f < state_.size(); ++f)
            if (state_[f] != kNone && tets_.neighbors[f / 4][f % 4] > f / 4)
                candidates.facets.push_back(f);
        candidates.triangles = triangles_of(tets_, candidates.facets, context_);
        candidates.around = vertex_triangles(tets_.num_real(), candidates.triangles);
        return candidates;
    }

    // Cocone's facets, and those that all their points agree on though none is flat (along creases
    // and borders), as long as they are not far larger than the spacing.
    bool is_candidate(const Cocone& cocone, HalfFacet f) const {
        const std::uint8_t flags = cocone.facets[f];
        if (flags == 0) return false;
        const auto [a, b, c] = tets_.triangle(f);
        const float x = cocone.spacing[a], y = cocone.spacing[b], z = cocone.spacing[c];
        const double spacing = std::max(std::min(x, y), std::min(std::max(x, y), z));  // the median
        const double reach = (flags & kSurfaceFacet) != 0 ? kReach : kAgreedReach;
        return circumradius2(tets_, f) <= reach * reach * spacing * spacing;
    }

    int num_candidates(Index cell) const {
        int n = 0;
        for (Index i = 0; i < 4; ++i) n += state_[cell * 4 + i] != kNone ? 1 : 0;
        return n;
    }

    // Marks the facets that hang over at v: those that are left over when facets with a free edge
    // at v are taken away one after the other, and a closed umbrella remains. It must go around v
    // if it is flat or the cloud noisy: a disc that has a gap must not give way to a sliver, or one
    // gap after the other eats the surface.
    void find_hanging(Index v, const Candidates& candidates, bool is_strict,
                      std::vector<Spoke>& spokes, std::vector<HalfFacet>& hanging) const {
        spokes.clear();
        for (Index number : candidates.around.of(v)) {
            const HalfFacet f = candidates.facets[number];
            if (state_[f] == kNone) continue;
            const Triangle& t = candidates.triangles[number];
            const std::size_t k = t[0] == v ? 0 : (t[1] == v ? 1 : 2);
            spokes.push_back({t[(k + 1) % 3], t[(k + 2) % 3], f, true});
        }
        std::size_t num_alive = spokes.size();
        for (bool changed = true; changed;) {
            changed = false;
            for (Spoke& s : spokes) {
                if (!s.alive || (has_other(spokes, s, s.from) && has_other(spokes, s, s.to)))
                    continue;
                s.alive = false, --num_alive;
                changed = true;
            }
        }
        if (num_alive == 0 || num_alive == spokes.size()) return;
        if ((is_strict || is_flat(v, spokes)) && !is_around(v, spokes)) return;
        for (const Spoke& s : spokes)
            if (!s.alive) hanging.push_back(s.facet);
    }

    // Whether the living facets lie in the tangent plane of v.
    bool is_flat(Index v, const std::vector<Spoke>& spokes) const {
        const double most = kFlatHeight * static_cast<double>(spacing_[v]);
        const auto height = [&](Index q) {
            return std::abs(dot(normals_[v], tets_.points[q] - tets_.points[v]));
        };
        return std::all_of(spokes.begin(), spokes.end(), [&](const Spoke& s) {
            return !s.alive || (height(s.from) <= most && height(s.to) <= most);
        });
    }

    // Whether the living facets go around v: seen along its normal, no half plane holds them all.
    // Those of a sliver with v at its rim do not.
    bool is_around(Index v, const std::vector<Spoke>& spokes) const {
        const Vec3d p = tets_.points[v], normal = normals_[v];
        return std::all_of(spokes.begin(), spokes.end(), [&](const Spoke& s) {
            const Vec3d left = cross(normal, tets_.points[s.from] - p);
            return !s.alive || std::any_of(spokes.begin(), spokes.end(), [&](const Spoke& other) {
                return other.alive && (dot(left, tets_.points[other.from] - p) > 0 ||
                                       dot(left, tets_.points[other.to] - p) > 0);
            });
        });
    }

    static bool has_other(const std::vector<Spoke>& spokes, const Spoke& own, Index end) {
        return std::any_of(spokes.begin(), spokes.end(), [&](const Spoke& s) {
            return s.alive && s.facet != own.facet && (s.from == end || s.to == end);
        });
    }

    // Only points at a facet that went can have new hanging ones.
    void prune() {
        const Candidates candidates = list_candidates();
        std::vector<Index> todo(tets_.num_real());
        std::iota(todo.begin(), todo.end(), Index{0});
        while (!todo.empty()) {
            std::vector<std::vector<HalfFacet>> parts((todo.size() + kGrain - 1) / kGrain);
            parallel_for(context_, todo.size(), kGrain, [&](std::size_t begin, std::size_t end) {
                std::vector<Spoke> spokes;
                for (std::size_t k = begin; k < end; ++k)
                    find_hanging(todo[k], candidates, is_noisy_, spokes, parts[begin / kGrain]);
            });
            todo.clear();
            for (const auto& part : parts) {
                for (HalfFacet f : part) {
                    set_state(f, kNone);
                    for (Index v : tets_.triangle(f)) todo.push_back(v);
                }
            }
            std::sort(todo.begin(), todo.end());
            todo.erase(std::unique(todo.begin(), todo.end()), todo.end());
        }
    }

    void set_state(HalfFacet f, State state) { state_[f] = state_[tets_.mirror(f)] = state; }

    Index keep(HalfFacet f) {
        set_state(f, kKept);
        number_[f] = static_cast<Index>(surface_.facets.size());
        surface_.facets.push_back(f);
        surface_.mates.push_back({kInvalidIndex, kInvalidIndex, kInvalidIndex});
        queue_.push_back(number_[f]);
        return number_[f];
    }

    void walk_from(HalfFacet start) {
        keep(start);
        for (std::size_t n = 0; !queue_.empty(); ++n) {
            if (n % kPollInterval == 0) check_cancelled(context_);
            const Index t = queue_.front();
            queue_.pop_front();
            for (Index k = 0; k < 3; ++k)
                if (surface_.mates[t][k] == kInvalidIndex) cross_edge(t, k);
        }
    }

    // The first facet on the walker's side becomes the neighbour; candidates behind it go.
    void cross_edge(Index t, Index k) {
        const HalfFacet own = surface_.facets[t];
        Turn turn = first_turn(tets_, own, k);
        const HalfFacet back = tets_.mirror(own);
        HalfFacet found = kInvalidIndex;
        for (;; turn = next_turn(tets_, turn)) {
            const HalfFacet f = turn.cell * 4 + static_cast<Index>(turn.exit);
            if (f == back) break;
            if (state_[f] == kNone) continue;
            if (found == kInvalidIndex)
                found = f;
            else if (state_[f] == kCandidate)
                set_state(f, kNone);
        }
        if (found == kInvalidIndex) return;
        if (state_[found] == kCandidate) keep(found);
        const Index other = number_[found];
        if (other == kInvalidIndex) return;  // kept from its other side: the orientations disagree
        const Index a = tets_.triangle(own)[(k + 1) % 3];
        const Triangle theirs = tets_.triangle(found);
        const Index start = theirs[0] == a ? 0 : (theirs[1] == a ? 1 : 2);
        if (surface_.mates[other][start] != kInvalidIndex) return;
        surface_.mates[t][k] = other * 3 + start;
        surface_.mates[other][start] = t * 3 + k;
    }

    // Drops the small pieces and turns the others so that their outer side sees more of the far
    // points.
    FacetSurface keep_large_pieces() const {
        std::vector<Triangle> triangles;
        std::vector<std::array<Index, 3>> neighbors = surface_.mates;
        for (HalfFacet f : surface_.facets) triangles.push_back(tets_.triangle(f));
        for (auto& mates : neighbors)
            for (Index& m : mates) m = m == kInvalidIndex ? m : m / 3;
        const Pieces pieces = find_pieces(neighbors);
        const auto is_kept = choose_pieces(tets_, spacing_, triangles, pieces);
        FacetSurface kept;
        std::vector<Index> renumbered(surface_.facets.size(), kInvalidIndex);
        std::vector<std::array<Index, 3>> edges(surface_.facets.size());
        for (std::size_t p = 0; p < pieces.size(); ++p) {
            if (is_kept[p] == 0) continue;
            const bool turn = is_inside_out(pieces.of(p));
            for (Index t : pieces.of(p)) {
                const HalfFacet own = surface_.facets[t];
                renumbered[t] = static_cast<Index>(kept.facets.size());
                kept.facets.push_back(turn ? tets_.mirror(own) : own);
                edges[t] = turn ? turned_edges(own) : std::array<Index, 3>{0, 1, 2};
            }
        }
        kept.mates.resize(kept.facets.size());
        for (Index t = 0; t < surface_.facets.size(); ++t) {
            if (renumbered[t] == kInvalidIndex) continue;
            for (std::size_t k = 0; k < 3; ++k) {
                const Index mate = surface_.mates[t][k];
                kept.mates[renumbered[t]][edges[t][k]] =
                    mate == kInvalidIndex ? mate
                                          : renumbered[mate / 3] * 3 + edges[mate / 3][mate % 3];
            }
        }
        return kept;
    }

    bool is_inside_out(std::span<const Index> piece) const {
        std::int64_t outer = 0, inner = 0;
        for (Index t : piece) {
            const HalfFacet f = surface_.facets[t];
            inner += tets_.has_far(f / 4) ? 1 : 0;
            outer += tets_.has_far(tets_.mirror(f) / 4) ? 1 : 0;
        }
        return inner > outer;
    }

    // Where each edge of a facet is found when it is seen from its other side.
    std::array<Index, 3> turned_edges(HalfFacet facet) const {
        const Triangle own = tets_.triangle(facet), other = tets_.triangle(tets_.mirror(facet));
        std::array<Index, 3> edges{};
        for (std::size_t k = 0; k < 3; ++k) {
            const Index start = own[(k + 1) % 3];  // it runs the other way there
            edges[k] = other[0] == start ? 0 : (other[1] == start ? 1 : 2);
        }
        return edges;
    }

    const Tetrahedra& tets_;
    std::span<const float> spacing_;
    std::span<const Vec3d> normals_;
    bool is_noisy_;
    const Context& context_;
    std::vector<std::uint8_t> state_;
    std::vector<Index> number_;
    std::deque<Index> queue_;
    FacetSurface surface_;
};

}  // namespace

FacetSurface extract_open(const Tetrahedra& tets, const Cocone& cocone, bool is_noisy,
                          const Context& context) {
    return Walker(tets, cocone, is_noisy, context).run();
}

}  // namespace pointbake
