// Based on [CohenSteiner04]: an advancing front over Delaunay facets, smooth continuations first.
// Departure: it starts from what Cocone found instead of a single facet, and sizes are measured in
// the local spacing.
#include "reconstruct/front.h"

#include <algorithm>
#include <optional>
#include <queue>

#include "core/parallel.h"
#include "core/union_find.h"

namespace pointbake {
namespace {

// Largest circumradius of an added facet in spacings.
constexpr double kReach = 1.2;
// Facets that continue the surface within 30 degrees come first, the smallest first; then those
// that bend less, up to 75 degrees.
constexpr double kSmoothCos = 0.8660254037844386, kLeastCos = 0.25881904510252074;
// Steps along a border after which two edges of it count as lying on two borders.
constexpr int kLongestWalk = 4096;
constexpr std::size_t kPollInterval = 1U << 10;

class Front {
 public:
    Front(const Tetrahedra& tets, std::span<const float> spacing, FacetSurface& surface)
        : tets_(tets),
          spacing_(spacing),
          surface_(surface),
          first_corner_(tets.num_real(), kInvalidIndex) {
        for (Index t = 0; t < surface_.facets.size(); ++t) link(t);
        for (Index t = 0; t < surface_.facets.size(); ++t)
            for (Index mate : surface_.mates[t])
                if (mate != kInvalidIndex) pieces_.unite(t, mate / 3);
    }

    void run(const Context& context) {
        const auto num_edges = static_cast<Index>(3 * surface_.facets.size());
        for (Index e = 0; e < num_edges; ++e) {
            if (e % kPollInterval == 0) check_cancelled(context);
            if (mate(e) == kInvalidIndex) push(e);
        }
        for (std::size_t n = 0; !queue_.empty(); ++n) {
            if (n % kPollInterval == 0) check_cancelled(context);
            const Offer offer = queue_.top();
            queue_.pop();
            if (mate(offer.edge) != kInvalidIndex) continue;
            if (const auto joints = find_joints(offer.edge, offer.facet))
                add(offer, *joints);
            else
                push(offer.edge);
        }
    }

 private:
    // The best facet for one border edge (3 * facet + edge); the lowest rank goes first.
    struct Offer {
        double rank;
        Index edge;
        HalfFacet facet;
        friend bool operator<(const Offer& x, const Offer& y) {
            return x.rank != y.rank ? x.rank > y.rank : x.edge > y.edge;
        }
    };
    // Border edges that a new facet meets beside the one it grows from; kInvalidIndex = none.
    struct Joints {
        std::size_t start;  // corner of the new facet where the edge that it grows from starts
        Index after, before;
    };

    Index mate(Index edge) const { return surface_.mates[edge / 3][edge % 3]; }

    void link(Index t) {
        pieces_.add();
        const Triangle v = tets_.triangle(surface_.facets[t]);
        for (Index k = 0; k < 3; ++k) {
            next_corner_.push_back(first_corner_[v[k]]);
            first_corner_[v[k]] = 3 * t + k;
        }
    }

    Triangle corners(Index t) const { return tets_.triangle(surface_.facets[t]); }

    // The border edge that follows along the border.
    Index next_border(Index edge) const {
        for (;;) {
            edge = edge / 3 * 3 + (edge % 3 + 1) % 3;
            if (mate(edge) == kInvalidIndex) return edge;
            edge = mate(edge);
        }
    }

    bool on_one_loop(Index x, Index y) const {
        Index p = x, q = y;
        for (int step = 0; step < kLongestWalk; ++step) {
            p = next_border(p), q = next_border(q);
            if (p == y || q == x) return true;
            if (p == x || q == y) return false;
        }
        return false;
    }

    // Whether `first` comes before `second` on the way along the border from `edge`.
    bool in_order(Index edge, Index first, Index second) const {
        Index p = edge;
        for (int step = 0; step < kLongestWalk; ++step) {
            p = next_border(p);
            if (p == first || p == second || p == edge) return p == first;
        }
        return false;
    }

    // Two border loops of one piece are never joined: that would make a handle.
    bool makes_handle(Index edge, const Joints& joints) {
        const auto [start, after, before] = joints;
        const auto is_own = [&](Index joint) {
            return joint != kInvalidIndex && pieces_.find(joint / 3) == pieces_.find(edge / 3);
        };
        if (is_own(after) && is_own(before))
            return !on_one_loop(edge, before) || !on_one_loop(edge, after) ||
                   !in_order(edge, before, after);
        if (is_own(after)) return !on_one_loop(edge, after);
        if (is_own(before)) return !on_one_loop(edge, before);
        return after != kInvalidIndex && before != kInvalidIndex &&
               pieces_.find(after / 3) == pieces_.find(before / 3) && !on_one_loop(after, before);
    }

    void push(Index edge) {
        const HalfFacet own = surface_.facets[edge / 3], back = tets_.mirror(own);
        const Vec3d n = tets_.area_vector(own);
        Offer best{HUGE_VAL, edge, kInvalidIndex};
        for (Turn turn = first_turn(tets_, own, edge % 3);; turn = next_turn(tets_, turn)) {
            const HalfFacet f = turn.cell * 4 + static_cast<Index>(turn.exit);
            if (f == back) break;
            if (tets_.is_far(turn.third)) continue;
            const double rank = rank_of(f, n);
            if (rank < best.rank && find_joints(best.edge, f)) best.rank = rank, best.facet = f;
        }
        if (best.facet != kInvalidIndex) queue_.push(best);
    }

    // Smooth continuations rank below 0, by their size in spacings; others by how much they bend.
    double rank_of(HalfFacet f, Vec3d n) const {
        const auto [a, b, c] = tets_.triangle(f);
        const float x = spacing_[a], y = spacing_[b], z = spacing_[c];
        const double spacing = std::max(std::min(x, y), std::min(std::max(x, y), z));  // the median
        const double size2 = circumradius2(tets_, f) / (spacing * spacing);
        if (!(size2 <= kReach * kReach)) return HUGE_VAL;
        const Vec3d m = tets_.area_vector(f);
        const double cosine = dot(n, m) / std::sqrt(squared_length(n) * squared_length(m));
        if (!(cosine >= kLeastCos)) return HUGE_VAL;
        return cosine >= kSmoothCos ? size2 - kReach * kReach - 1.0 : 1.0 - cosine;
    }

    // Whether the facet may be added at this border edge: each of its two other edges is new or
    // meets a border edge that runs the other way, and its third point is new or on a border.
    std::optional<Joints> find_joints(Index edge, HalfFacet facet) {
        const Triangle own = corners(edge / 3), v = tets_.triangle(facet);
        const Index a = own[edge % 3], b = own[(edge % 3 + 1) % 3];
        const std::size_t start = v[0] == b ? 0 : (v[1] == b ? 1 : 2);
        const Index w = v[(start + 2) % 3];
        Index own_edge = kInvalidIndex;
        if (!find_joint(b, a, own_edge) || own_edge != edge) return std::nullopt;
        Joints joints{start, kInvalidIndex, kInvalidIndex};
        if (!find_joint(a, w, joints.after) || !find_joint(w, b, joints.before))
            return std::nullopt;
        if (joints.after == kInvalidIndex && joints.before == kInvalidIndex &&
            first_corner_[w] != kInvalidIndex && !is_on_border(w))
            return std::nullopt;
        const bool is_back_to_back = joints.after != kInvalidIndex &&
                                     joints.before != kInvalidIndex &&
                                     joints.after / 3 == joints.before / 3;
        if (is_back_to_back || makes_handle(edge, joints)) return std::nullopt;
        return joints;
    }

    // Looks for facets at the edge that the new one runs through from p to q: none, or one whose
    // border runs from q to p.
    bool find_joint(Index p, Index q, Index& joint) const {
        for (Index c = first_corner_[p]; c != kInvalidIndex; c = next_corner_[c]) {
            const Triangle v = corners(c / 3);
            const Index k = c % 3;
            if (v[(k + 1) % 3] == q) return false;
            if (v[(k + 2) % 3] != q) continue;
            const Index back = 3 * (c / 3) + (k + 2) % 3;
            if (joint != kInvalidIndex || mate(back) != kInvalidIndex) return false;
            joint = back;
        }
        return true;
    }

    bool is_on_border(Index v) const {
        for (Index c = first_corner_[v]; c != kInvalidIndex; c = next_corner_[c])
            if (mate(c) == kInvalidIndex) return true;
        return false;
    }

    void add(const Offer& offer, const Joints& joints) {
        const auto t = static_cast<Index>(surface_.facets.size());
        surface_.facets.push_back(offer.facet);
        surface_.mates.push_back({kInvalidIndex, kInvalidIndex, kInvalidIndex});
        link(t);
        join(offer.edge, 3 * t + static_cast<Index>(joints.start));
        for (const auto& [step, joint] :
             {std::pair{1U, joints.after}, std::pair{2U, joints.before}}) {
            const Index k = static_cast<Index>((joints.start + step) % 3);
            if (joint == kInvalidIndex)
                push(3 * t + k);
            else
                join(joint, 3 * t + k);
        }
    }

    void join(Index x, Index y) {
        surface_.mates[x / 3][x % 3] = y;
        surface_.mates[y / 3][y % 3] = x;
        pieces_.unite(x / 3, y / 3);
    }

    const Tetrahedra& tets_;
    std::span<const float> spacing_;
    FacetSurface& surface_;
    std::vector<Index> first_corner_, next_corner_;  // chains of corners 3 * facet + k per point
    UnionFind pieces_{0};                            // of facets
    std::priority_queue<Offer> queue_;
};

}  // namespace

void grow_in_place(const Tetrahedra& tets, std::span<const float> spacing, FacetSurface& surface,
                   const Context& context) {
    Front(tets, spacing, surface).run(context);
}

}  // namespace pointbake
