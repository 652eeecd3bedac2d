// [Liepa03]: the triangulation of a hole by dynamic programming. Departure: no refinement and no
// fairing, as the holes are not much wider than the points lie apart.
#include "reconstruct/holes.h"

#include <algorithm>
#include <utility>

#include "core/adjacency.h"
#include "core/parallel.h"
#include "reconstruct/pieces.h"

namespace pointbake {
namespace {

constexpr std::size_t kMostEdges = 64;
// Longest edge across a hole, in the mean spacing of its ends.
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

// Vertices of a border, with the hole to the left: against the border's own direction.
struct Loop {
    std::vector<Index> vertices;
    double piece_area = 0.0;
};

class Hole {
 public:
    Hole(std::span<const Vec3d> points, std::span<const float> spacing,
         const VertexTriangles& around, const std::vector<Triangle>& triangles, const Loop& loop)
        : points_(points),
          spacing_(spacing),
          around_(around),
          triangles_(triangles),
          loop_(loop.vertices),
          most_area_(kMostArea * loop.piece_area),
          weights_(loop_.size() * loop_.size(), kNever),
          middles_(loop_.size() * loop_.size(), 0) {}

    // Nothing if the hole should stay open.
    std::vector<Triangle> fill() {
        const std::size_t n = loop_.size();
        for (std::size_t i = 0; i + 1 < n; ++i) weights_[i * n + i + 1] = {};
        for (std::size_t length = 2; length < n; ++length)
            for (std::size_t i = 0; i + length < n; ++i) find_middle(i, i + length);
        std::vector<Triangle> out;
        if (weights_[n - 1].area <= most_area_) list(0, n - 1, out);
        return out;
    }

 private:
    Vec3d point(std::size_t i) const { return points_[loop_[i]]; }

    Vec3d area_vector(std::size_t i, std::size_t j, std::size_t k) const {
        return cross(point(j) - point(i), point(k) - point(i));
    }

    // The normal of what lies on the other side of the polygon's edge or chord from i to k.
    Vec3d normal_behind(std::size_t i, std::size_t k) const {
        if (k != i + 1 && !(i == 0 && k + 1 == loop_.size()))
            return area_vector(i, middles_[i * loop_.size() + k], k);
        for (Index t : around_.of(loop_[i])) {
            const Triangle& v = triangles_[t];
            if (std::find(v.begin(), v.end(), loop_[k]) != v.end())
                return cross(points_[v[1]] - points_[v[0]], points_[v[2]] - points_[v[0]]);
        }
        return {};
    }

    bool is_free(std::size_t i, std::size_t k) const {
        if (k == i + 1 || (i == 0 && k + 1 == loop_.size())) return true;
        const double reach = 0.5 * kReach * (spacing_[loop_[i]] + spacing_[loop_[k]]);
        const double length2 = squared_length(point(i) - point(k));
        if (length2 == 0.0 || length2 > reach * reach) return false;  // 0: copies of one point
        for (Index t : around_.of(loop_[i])) {
            const Triangle& v = triangles_[t];
            if (std::find(v.begin(), v.end(), loop_[k]) != v.end()) return false;
        }
        return true;
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
    double most_area_;
    std::vector<Weight> weights_;  // per pair i < k of the loop's vertices
    std::vector<std::size_t> middles_;
};

double area_of(std::span<const Vec3d> points, const Triangle& t) {
    return 0.5 * length(cross(points[t[1]] - points[t[0]], points[t[2]] - points[t[0]]));
}

// The short loops. Each vertex lies on one border at most.
std::vector<Loop> find_loops(std::span<const Vec3d> points, const IndexedSurface& surface) {
    const auto neighbors = triangle_neighbors(surface.triangles);
    const Pieces pieces = find_pieces(neighbors);
    std::vector<Index> before(surface.vertex_points.size(), kInvalidIndex);
    std::vector<double> piece_areas(before.size(), 0.0);
    for (std::size_t p = 0; p < pieces.size(); ++p) {
        double area = 0.0;
        for (Index t : pieces.of(p)) area += area_of(points, surface.triangles[t]);
        for (Index t : pieces.of(p)) {
            const Triangle& v = surface.triangles[t];
            for (std::size_t k = 0; k < 3; ++k) {
                if (neighbors[t][k] != kInvalidIndex) continue;
                before[v[(k + 1) % 3]] = v[k];
                piece_areas[v[k]] = area;
            }
        }
    }
    std::vector<Loop> loops;
    for (Index first = 0; first < before.size(); ++first) {
        if (before[first] == kInvalidIndex) continue;
        Loop loop{{}, piece_areas[first]};
        for (Index v = first; v != kInvalidIndex;) {
            if (loop.vertices.size() <= kMostEdges + 1) loop.vertices.push_back(v);
            v = std::exchange(before[v], kInvalidIndex);
        }
        loop.vertices.pop_back();  // `first` comes at both ends
        if (loop.vertices.size() >= 3 && loop.vertices.size() <= kMostEdges)
            loops.push_back(std::move(loop));
    }
    return loops;
}

}  // namespace

void fill_holes_in_place(std::span<const Vec3d> points, std::span<const float> spacing,
                         IndexedSurface& surface, const Context& context) {
    const std::vector<Loop> loops = find_loops(points, surface);
    const auto around = vertex_triangles(surface.vertex_points.size(), surface.triangles);
    std::vector<std::vector<Triangle>> fills(loops.size());
    parallel_for(context, loops.size(), 1, [&](std::size_t i, std::size_t) {
        fills[i] = Hole(points, spacing, around, surface.triangles, loops[i]).fill();
    });
    for (const auto& fill : fills)
        surface.triangles.insert(surface.triangles.end(), fill.begin(), fill.end());
}

}  // namespace pointbake
