// Marching tetrahedra with signs -, + and 0 (on the surface; counts as +). Moving vertices onto the
// surface is isosurface stuffing's idea [Labelle07]. Without zeros the mesh is a 2-manifold; making
// a vertex v zero contracts what the surface has on the edges from v to the inside. What remains
// around v is a closed fan, if it is a simple cycle on the tetrahedra around v; where it is not, v
// keeps its sign.
#include "reconstruct/contour.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "core/parallel.h"
#include "core/parallel_sort.h"

namespace pointbake {
namespace {

using Tet = std::array<Index, 4>;
using Key = std::uint64_t;  ///< of a mesh vertex: node outside, node inside

constexpr std::size_t kGrain = 4096;
// A vertex is moved if an edge is cut within this share of its length from it.
constexpr float kSnapShare = 0.25F;
// And if its value is no larger: a quarter of the longest edge near the points.
constexpr float kMostSnapped = 1.0F;

enum Sign : std::int8_t { kInside = -1, kZero = 0, kOutside = 1, kNone = 2 };

Key key_of(Index outside, Index inside) { return Key{outside} << 32 | inside; }

/// At most two triangles.
struct Facets {
    std::array<std::array<Key, 3>, 2> items;
    std::size_t size = 0;
    void add(Key a, Key b, Key c) { items[size++] = {a, b, c}; }
};

class Marcher {
 public:
    Marcher(const SimplexGrid& grid, std::span<const float> values, const Context& context)
        : grid_(grid), values_(values), context_(context), signs_(grid.num_nodes()) {
        for (Index i = 0; i < signs_.size(); ++i)
            signs_[i] = std::isnan(values[i]) ? kNone : (values[i] < 0.0F ? kInside : kOutside);
    }

    Contour run(std::span<const std::uint8_t> may_snap) {
        tets_ = grid_.leaves(context_,
                             [&](const Tet& t) { return is_mixed(t) || may_be_lid(t, may_snap); });
        snap(may_snap);
        return assemble();
    }

 private:
    bool is_mixed(const Tet& t) const {
        bool has_inside = false, has_outside = false;
        for (const Index v : t) {
            if (signs_[v] == kNone) return false;
            (signs_[v] == kInside ? has_inside : has_outside) = true;
        }
        return has_inside && has_outside;
    }

    bool may_move(Index v, std::span<const std::uint8_t> may_snap) const {
        return may_snap[v] && std::abs(values_[v]) <= kMostSnapped;
    }
    /// Tetrahedra inside of which three vertices are moved have a facet, too.
    bool may_be_lid(const Tet& t, std::span<const std::uint8_t> may_snap) const {
        int num_near = 0;
        for (const Index v : t) {
            if (signs_[v] != kInside) return false;
            num_near += may_move(v, may_snap) ? 1 : 0;
        }
        return num_near >= 3;
    }

    void snap(std::span<const std::uint8_t> may_snap);
    void find_candidates(std::span<const std::uint8_t> may_snap);
    void find_stars();
    bool is_fan(Index zero) const;
    Facets facets(const Tet& t) const;
    Contour assemble() const;
    Key cut(Index outside, Index inside) const {
        return signs_[outside] == kZero ? key_of(outside, outside) : key_of(outside, inside);
    }

    const SimplexGrid& grid_;
    std::span<const float> values_;
    const Context& context_;
    std::vector<Sign> signs_;
    std::vector<Tet> tets_;
    std::vector<Index> zeros_;                    ///< nodes
    std::vector<Index> star_begin_, star_items_;  ///< tetrahedra around each zero
};

void Marcher::find_candidates(std::span<const std::uint8_t> may_snap) {
    std::vector<std::uint8_t> is_near(signs_.size());
    for (const Tet& t : tets_)
        for (const Index a : t)
            for (const Index b : t) {
                if (signs_[a] == signs_[b]) continue;
                const float fa = std::abs(values_[a]), fb = std::abs(values_[b]);
                if (fa <= kSnapShare * (fa + fb)) is_near[a] = may_move(a, may_snap);
            }
    for (Index v = 0; v < is_near.size(); ++v)
        if (is_near[v]) zeros_.push_back(v), signs_[v] = kZero;
}

void Marcher::find_stars() {
    std::vector<Index> slot(signs_.size(), kInvalidIndex);
    for (Index i = 0; i < zeros_.size(); ++i) slot[zeros_[i]] = i;
    star_begin_.assign(zeros_.size() + 1, 0);
    for (const Tet& t : tets_)
        for (const Index v : t)
            if (slot[v] != kInvalidIndex) ++star_begin_[slot[v] + 1];
    std::partial_sum(star_begin_.begin(), star_begin_.end(), star_begin_.begin());
    star_items_.resize(star_begin_.back());
    std::vector<Index> next(star_begin_.begin(), star_begin_.end() - 1);
    for (Index i = 0; i < tets_.size(); ++i)
        for (const Index v : tets_[i])
            if (slot[v] != kInvalidIndex) star_items_[next[slot[v]]++] = i;
}

/// Whether the facets around a zero make one closed fan, or there is none.
bool Marcher::is_fan(Index zero) const {
    const Key center = key_of(zeros_[zero], zeros_[zero]);
    std::vector<std::array<Key, 2>> rim;  // directed: from each key to the next one
    for (Index i = star_begin_[zero]; i < star_begin_[zero + 1]; ++i) {
        const Facets f = facets(tets_[star_items_[i]]);
        for (std::size_t k = 0; k < f.size; ++k)
            for (std::size_t c = 0; c < 3; ++c)
                if (f.items[k][c] == center)
                    rim.push_back({f.items[k][(c + 1) % 3], f.items[k][(c + 2) % 3]});
    }
    if (rim.empty()) return true;
    std::ranges::sort(rim);
    const auto follow = [&](Key from) {
        return std::ranges::lower_bound(rim, std::array<Key, 2>{from, 0});
    };
    for (std::size_t i = 1; i < rim.size(); ++i)
        if (rim[i][0] == rim[i - 1][0]) return false;
    std::size_t steps = 0;
    Key at = rim[0][0];
    do {
        const auto next = follow(at);
        if (next == rim.end() || (*next)[0] != at) return false;
        at = (*next)[1];
        ++steps;
    } while (at != rim[0][0] && steps <= rim.size());
    return steps == rim.size() && steps >= 3;
}

void Marcher::snap(std::span<const std::uint8_t> may_snap) {
    find_candidates(may_snap);
    find_stars();
    // Giving signs back brings others about; there are few.
    std::vector<std::uint8_t> is_bad(zeros_.size());
    for (bool changed = true; changed;) {
        parallel_for(context_, zeros_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                is_bad[i] = signs_[zeros_[i]] == kZero && !is_fan(static_cast<Index>(i));
        });
        changed = false;
        for (std::size_t i = 0; i < zeros_.size(); ++i) {
            if (!is_bad[i]) continue;
            signs_[zeros_[i]] = values_[zeros_[i]] < 0.0F ? kInside : kOutside;
            changed = true;
        }
    }
}

Facets Marcher::facets(const Tet& t) const {
    Facets out;
    Tet v;  // those inside come first
    std::size_t num_inside = 0;
    for (const Index i : t)
        if (signs_[i] == kInside) v[num_inside++] = i;
    std::size_t count = num_inside;
    for (const Index i : t)
        if (signs_[i] != kInside) v[count++] = i;
    if (num_inside == 0 || num_inside == 4) return out;
    const auto add = [&](Key a, Key b, Key c) {
        if (a != b && b != c && c != a) out.add(a, b, c);
    };
    // As if positively oriented, else turned round in the end.
    if (num_inside == 1) {
        add(cut(v[1], v[0]), cut(v[2], v[0]), cut(v[3], v[0]));
    } else if (num_inside == 3) {
        add(cut(v[3], v[0]), cut(v[3], v[1]), cut(v[3], v[2]));
    } else {
        const std::array<Key, 4> quad{cut(v[2], v[0]), cut(v[3], v[0]), cut(v[3], v[1]),
                                      cut(v[2], v[1])};
        add(quad[0], quad[1], quad[2]);
        add(quad[0], quad[2], quad[3]);
    }
    if (grid_.orientation(v) < 0)
        for (std::size_t k = 0; k < out.size; ++k) std::swap(out.items[k][1], out.items[k][2]);
    return out;
}

Contour Marcher::assemble() const {
    const std::size_t num_chunks = (tets_.size() + kGrain - 1) / kGrain;
    std::vector<std::vector<std::array<Key, 3>>> parts(num_chunks);
    parallel_for(context_, tets_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (!is_mixed(tets_[i])) continue;
            const Facets f = facets(tets_[i]);
            for (std::size_t k = 0; k < f.size; ++k) parts[begin / kGrain].push_back(f.items[k]);
        }
    });
    std::vector<Key> keys;
    for (const auto& part : parts)
        for (const auto& facet : part) keys.insert(keys.end(), facet.begin(), facet.end());
    parallel_sort(context_, keys);
    keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
    Contour contour;
    contour.vertices.resize(keys.size());
    for (std::size_t i = 0; i < keys.size(); ++i)
        contour.vertices[i] = {static_cast<Index>(keys[i] >> 32), static_cast<Index>(keys[i])};
    const auto index_of = [&](Key key) {
        return static_cast<Index>(std::ranges::lower_bound(keys, key) - keys.begin());
    };
    std::vector<std::size_t> first(num_chunks + 1);
    for (std::size_t c = 0; c < num_chunks; ++c) first[c + 1] = first[c] + parts[c].size();
    contour.triangles.resize(first.back());
    parallel_for(context_, num_chunks, 1, [&](std::size_t c, std::size_t) {
        for (std::size_t i = 0; i < parts[c].size(); ++i)
            for (std::size_t k = 0; k < 3; ++k)
                contour.triangles[first[c] + i][k] = index_of(parts[c][i][k]);
    });
    return contour;
}

}  // namespace

Contour find_contour(const SimplexGrid& grid, std::span<const float> values,
                     std::span<const std::uint8_t> may_snap, const Context& context) {
    return Marcher(grid, values, context).run(may_snap);
}

}  // namespace pointbake
