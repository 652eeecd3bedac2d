// [Liepa03]: the triangulation of a hole by dynamic programming. Departures: no refinement and no
// fairing, as holes are not much wider than the points lie apart unless wider ones are asked for;
// long loops have ears cut off first, as it takes cubic time.
#include "reconstruct/holes.h"

#include <algorithm>
#include <functional>
#include <utility>

#include "core/adjacency.h"
#include "core/parallel.h"
#include "reconstruct/ears.h"
#include "reconstruct/pieces.h"

namespace pointbake {
namespace {

// Longest loops: of gaps, of holes of a size, and of those that need no ears cut off.
constexpr std::size_t kMostGapEdges = 64, kMostEdges = 8192, kMostUncut = 128;
// Longest edge across a gap, in the mean spacing of its ends.
constexpr double kReach = 6.0;
// A loop whose filling has more of its piece's area is the piece's rim, not a hole in it.
constexpr double kMostArea = 0.25;

// How bad a triangulation is: the sharpest bend, then the area.
struct Weight {
    double bend = -1.0, area = 0.0;  // -cosine
    friend bool operator<(const Weight& x, const Weight& y) {
        return x.bend != y.bend ? x.bend < y.bend : x.area < y.area;
    }
    friend Weight operator+(const Weight& x, const Weight& y) {
        return {std::max(x.bend, y.bend), x.area + y.area};
    }
};
constexpr Weight kNever{HUGE_VAL, HUGE_VAL};

double bend(Vec3d m, Vec3d n) {
    const double lengths = std::sqrt(squared_length(m) * squared_length(n));
    return lengths > 0.0 ? -dot(m, n) / lengths : 1.0;
}

bool has_edge(const VertexTriangles& around, const std::vector<Triangle>& triangles, Index a,
              Index b) {
    const auto shared = around.of(a);
    return std::any_of(shared.begin(), shared.end(), [&](Index t) {
        const Triangle& v = triangles[t];
        return v[0] == b || v[1] == b || v[2] == b;
    });
}

class Hole {
 public:
    // `spacing` is empty for a hole of a size, whose chords may have any length.
    Hole(std::span<const Vec3d> points, std::span<const float> spacing,
         const VertexTriangles& around, const std::vector<Triangle>& triangles, const Loop& loop)
        : points_(points),
          spacing_(spacing),
          around_(around),
          triangles_(triangles),
          loop_(loop.vertices),
          normals_(loop.normals),
          weights_(loop_.size() * loop_.size(), kNever),
          middles_(loop_.size() * loop_.size(), 0) {}

    // Nothing if there is no way.
    std::vector<Triangle> fill() {
        const std::size_t n = loop_.size();
        for (std::size_t i = 0; i + 1 < n; ++i) weights_[i * n + i + 1] = {};
        for (std::size_t length = 2; length < n; ++length)
            for (std::size_t i = 0; i + length < n; ++i) find_middle(i, i + length);
        std::vector<Triangle> out;
        if (weights_[n - 1].area < HUGE_VAL) list(0, n - 1, out);
        return out;
    }

 private:
    Vec3d point(std::size_t i) const { return points_[loop_[i]]; }

    Vec3d area_vector(std::size_t i, std::size_t j, std::size_t k) const {
        return cross(point(j) - point(i), point(k) - point(i));
    }

    // The normal of what lies on the other side of the polygon's edge or chord from i to k.
    Vec3d normal_behind(std::size_t i, std::size_t k) const {
        if (k == i + 1) return normals_[i];
        if (i == 0 && k + 1 == loop_.size()) return normals_[k];
        return area_vector(i, middles_[i * loop_.size() + k], k);
    }

    bool is_free(std::size_t i, std::size_t k) const {
        if (k == i + 1 || (i == 0 && k + 1 == loop_.size())) return true;
        const double length2 = squared_length(point(i) - point(k));
        if (length2 == 0.0) return false;  // copies of one point
        if (!spacing_.empty()) {
            const double reach = 0.5 * kReach * (spacing_[loop_[i]] + spacing_[loop_[k]]);
            if (length2 > reach * reach) return false;
        }
        return !has_edge(around_, triangles_, loop_[i], loop_[k]);
    }

    // The best triangle over the chord from i to k, given those of all shorter chords.
    void find_middle(std::size_t i, std::size_t k) {
        const std::size_t n = loop_.size();
        if (!is_free(i, k)) return;
        for (std::size_t m = i + 1; m < k; ++m) {
            const Weight parts = weights_[i * n + m] + weights_[m * n + k];
            if (!(parts < weights_[i * n + k])) continue;
            const Vec3d normal = area_vector(i, m, k);
            Weight own{
                std::max(bend(normal, normal_behind(i, m)), bend(normal, normal_behind(m, k))),
                0.5 * length(normal)};
            if (i == 0 && k + 1 == n)
                own.bend = std::max(own.bend, bend(normal, normal_behind(i, k)));
            if (!(parts + own < weights_[i * n + k])) continue;
            weights_[i * n + k] = parts + own;
            middles_[i * n + k] = m;
        }
    }

    void list(std::size_t i, std::size_t k, std::vector<Triangle>& out) const {
        if (k < i + 2) return;
        const std::size_t m = middles_[i * loop_.size() + k];
        out.push_back({loop_[i], loop_[m], loop_[k]});
        list(i, m, out);
        list(m, k, out);
    }

    std::span<const Vec3d> points_;
    std::span<const float> spacing_;
    const VertexTriangles& around_;
    const std::vector<Triangle>& triangles_;
    std::span<const Index> loop_;
    std::span<const Vec3d> normals_;
    std::vector<Weight> weights_;  // per pair i < k of the loop's vertices
    std::vector<std::size_t> middles_;
};

Vec3d area_vector(std::span<const Vec3d> points, const Triangle& t) {
    return cross(points[t[1]] - points[t[0]], points[t[2]] - points[t[0]]);
}

double area_of(std::span<const Vec3d> points, std::span<const Triangle> triangles) {
    double area = 0.0;
    for (const Triangle& t : triangles) area += 0.5 * length(area_vector(points, t));
    return area;
}

// The loops of at most so many edges. Each vertex lies on one border at most.
std::vector<Loop> find_loops(std::span<const Vec3d> points, const IndexedSurface& surface,
                             std::size_t most_edges) {
    const auto neighbors = triangle_neighbors(surface.triangles);
    const Pieces pieces = find_pieces(neighbors);
    const std::size_t n = surface.vertex_points.size();
    std::vector<Index> before(n, kInvalidIndex), behind(n), pieces_of(n);
    std::vector<double> piece_areas(pieces.size(), 0.0);
    for (Index p = 0; p < pieces.size(); ++p) {
        for (Index t : pieces.of(p)) {
            const Triangle& v = surface.triangles[t];
            piece_areas[p] += area_of(points, std::span(&v, 1));
            for (std::size_t k = 0; k < 3; ++k) {
                if (neighbors[t][k] != kInvalidIndex) continue;
                before[v[(k + 1) % 3]] = v[k];
                behind[v[(k + 1) % 3]] = t;
                pieces_of[v[k]] = p;
            }
        }
    }
    std::vector<Loop> loops;
    for (Index first = 0; first < n; ++first) {
        if (before[first] == kInvalidIndex) continue;
        Loop loop{{}, {}, piece_areas[pieces_of[first]]};
        for (Index v = first; before[v] != kInvalidIndex;) {
            if (loop.vertices.size() <= most_edges) {
                loop.vertices.push_back(v);
                loop.normals.push_back(area_vector(points, surface.triangles[behind[v]]));
            }
            v = std::exchange(before[v], kInvalidIndex);
        }
        if (loop.vertices.size() >= 3 && loop.vertices.size() <= most_edges)
            loops.push_back(std::move(loop));
    }
    return loops;
}

bool is_within(std::span<const Vec3d> points, const Loop& loop, double size) {
    for (std::size_t i = 0; i < loop.vertices.size(); ++i)
        for (std::size_t k = 0; k < i; ++k)
            if (squared_length(points[loop.vertices[i]] - points[loop.vertices[k]]) > size * size)
                return false;
    return true;
}

}  // namespace

Index fill_holes_in_place(std::span<const Vec3d> points, std::span<const float> spacing,
                          const HoleRule& rule, IndexedSurface& surface, const Context& context) {
    const std::vector<Loop> loops =
        find_loops(points, surface, rule.size ? kMostEdges : kMostGapEdges);
    if (rule.size) spacing = {};
    const auto& triangles = surface.triangles;
    const auto around = vertex_triangles(surface.vertex_points.size(), triangles);
    const std::function<bool(Index, Index)> is_edge = [&](Index a, Index b) {
        return has_edge(around, triangles, a, b);
    };
    const auto is_held = [&](const Triangle& t) {
        return rule.reach->holds(points[t[0]], points[t[1]], points[t[2]]);
    };
    const auto fill = [&](Loop loop) {
        std::vector<Triangle> out;
        if (rule.size && !is_within(points, loop, *rule.size)) return out;
        if (loop.vertices.size() > kMostUncut &&
            !cut_ears_in_place(points, kMostUncut, is_edge, loop, out))
            return std::vector<Triangle>{};
        const auto rest = Hole(points, spacing, around, triangles, loop).fill();
        out.insert(out.end(), rest.begin(), rest.end());
        const bool is_small = !rest.empty() && area_of(points, out) <= kMostArea * loop.piece_area;
        const bool is_near =
            rule.size || rule.reach == nullptr || std::all_of(out.begin(), out.end(), is_held);
        return is_small && is_near ? out : std::vector<Triangle>{};
    };
    std::vector<std::vector<Triangle>> fills(loops.size());
    parallel_for(context, loops.size(), 1,
                 [&](std::size_t i, std::size_t) { fills[i] = fill(loops[i]); });
    Index num_filled = 0;
    for (const auto& added : fills) {
        num_filled += added.empty() ? 0 : 1;
        surface.triangles.insert(surface.triangles.end(), added.begin(), added.end());
    }
    return num_filled;
}

}  // namespace pointbake
