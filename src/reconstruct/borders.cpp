#include "reconstruct/borders.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <queue>

#include "core/adjacency.h"
#include "core/parallel.h"
#include "core/segment.h"

namespace pointbake {
namespace {

// A notch is filled by a triangle within 45 degrees of both that it joins.
constexpr double kLeastCos = 0.7071067811865476;
// A border may recede so often from one place: what is one triangle wide all along is not eaten up.
constexpr int kMostSteps = 6;
constexpr std::size_t kGrain = 1U << 8;

class Trimmer {
 public:
    Trimmer(std::span<const Vec3d> points, std::span<const Index> ids, const Reach& reach,
            IndexedSurface& surface, const Context& context)
        : points_(points),
          triangles_(surface.triangles),
          around_(vertex_triangles(points.size(), triangles_)),
          is_gone_(triangles_.size(), 0),
          next_(points.size(), kInvalidIndex),
          before_(points.size(), kInvalidIndex),
          behind_(points.size(), kInvalidIndex),
          count_(points.size(), 0),
          spacing_(points.size(), 0.0F),
          steps_(points.size(), 0),
          reach_(reach) {
        const auto neighbors = triangle_neighbors(triangles_);
        for (Index t = 0; t < triangles_.size(); ++t) {
            for (std::size_t k = 0; k < 3; ++k) {
                const Index a = triangles_[t][k], b = triangles_[t][(k + 1) % 3];
                ++count_[a];
                if (neighbors[t][k] == kInvalidIndex) next_[a] = b, before_[b] = a, behind_[a] = t;
            }
        }
        for (Index v = 0; v < points.size(); ++v)
            if (next_[v] != kInvalidIndex) border_.push_back(v);
        parallel_for(context, border_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                spacing_[border_[i]] = static_cast<float>(reach.spacing(ids[border_[i]]));
        });
    }

    void run() {
        for (const bool teeth : {false, true, false}) work_off(teeth);
        std::vector<Triangle> kept;
        for (std::size_t t = 0; t < triangles_.size(); ++t)
            if (is_gone_[t] == 0) kept.push_back(triangles_[t]);
        triangles_ = std::move(kept);
    }

 private:
    struct Offer {
        double depth;  // in spacings
        Index vertex, from, to;
        friend bool operator<(const Offer& x, const Offer& y) {
            return x.depth != y.depth ? x.depth < y.depth : x.vertex > y.vertex;
        }
    };

    void work_off(bool teeth) {
        for (Index v : border_) offer(v);
        while (!offers_.empty()) {
            const Offer best = offers_.top();
            offers_.pop();
            const Index v = best.vertex, p = best.from, n = best.to;
            if (next_[v] != n || before_[v] != p || next_[n] == p) continue;
            if (!(teeth ? clip(v, p, n) : fill(v, p, n))) continue;
            next_[v] = before_[v] = kInvalidIndex;
            next_[p] = n, before_[n] = p;
            for (Index w : {p, n}) {
                if (teeth)
                    steps_[w] = std::max(steps_[w], static_cast<std::uint8_t>(steps_[v] + 1));
                offer(w);
            }
        }
    }

    void offer(Index v) {
        const Index p = before_[v], n = next_[v];
        if (n == kInvalidIndex) return;
        const double depth =
            std::sqrt(squared_distance_to_segment(points_[v], points_[p], points_[n]));
        if (depth > static_cast<double>(spacing_[v])) offers_.push({depth / spacing_[v], v, p, n});
    }

    Vec3d normal(Index a, Index b, Index c) const {
        return cross(points_[b] - points_[a], points_[c] - points_[a]);
    }
    Vec3d normal(Index t) const {
        return normal(triangles_[t][0], triangles_[t][1], triangles_[t][2]);
    }

    // The triangle along which the edge runs from a to b, kInvalidIndex = none.
    Index triangle_at(Index a, Index b) const {
        if (const auto added = added_.find({a, b}); added != added_.end()) return added->second;
        for (Index t : around_.of(a)) {
            if (is_gone_[t] != 0) continue;
            for (std::size_t k = 0; k < 3; ++k)
                if (triangles_[t][k] == a && triangles_[t][(k + 1) % 3] == b) return t;
        }
        return kInvalidIndex;
    }

    bool clip(Index v, Index p, Index n) {
        if (count_[v] != 1 || steps_[v] >= kMostSteps) return false;
        is_gone_[behind_[v]] = 1;
        --count_[v], --count_[p], --count_[n];
        behind_[p] = triangle_at(p, n);
        return true;
    }

    bool fill(Index v, Index p, Index n) {
        const Vec3d own = normal(v, p, n);
        for (Index t : {behind_[p], behind_[v]}) {
            const Vec3d other = normal(t);
            if (!(dot(own, other) >=
                  kLeastCos * std::sqrt(squared_length(own) * squared_length(other))))
                return false;
        }
        if (triangle_at(p, n) != kInvalidIndex || triangle_at(n, p) != kInvalidIndex) return false;
        if (!is_empty(v, p, n, own) || !reach_.holds(points_[v], points_[p], points_[n]))
            return false;
        const auto t = static_cast<Index>(triangles_.size());
        triangles_.push_back({v, p, n});
        is_gone_.push_back(0);
        added_[{v, p}] = added_[{p, n}] = added_[{n, v}] = t;
        ++count_[v], ++count_[p], ++count_[n];
        behind_[p] = t;
        return true;
    }

    // No border vertex over the triangle nearby along the border; others that far from it would
    // have points of their own in between.
    bool is_empty(Index v, Index p, Index n, Vec3d own) const {
        const std::array<Index, 3> corners{v, p, n};
        Index forth = n, back = p;
        for (int step = 0; step < 64; ++step) {
            forth = next_[forth], back = before_[back];
            for (Index w : {forth, back}) {
                if (w == v || w == p || w == n) continue;
                bool inside = true;
                for (std::size_t k = 0; k < 3 && inside; ++k) {
                    const Vec3d a = points_[corners[k]], b = points_[corners[(k + 1) % 3]];
                    inside = dot(cross(b - a, points_[w] - a), own) >= 0.0;
                }
                if (inside) return false;
            }
        }
        return true;
    }

    std::span<const Vec3d> points_;
    std::vector<Triangle>& triangles_;
    VertexTriangles around_;
    std::vector<std::uint8_t> is_gone_;
    std::vector<Index> next_, before_;  // per vertex along its border
    std::vector<Index> behind_;         // triangle at the border's edge to the next vertex
    std::vector<Index> count_;          // triangles per vertex
    std::vector<float> spacing_;
    std::vector<std::uint8_t> steps_;
    const Reach& reach_;
    std::vector<Index> border_;
    std::map<std::pair<Index, Index>, Index> added_;
    std::priority_queue<Offer> offers_;
};

}  // namespace

void trim_borders_in_place(std::span<const Vec3d> points, std::span<const Index> ids,
                           const Reach& reach, IndexedSurface& surface, const Context& context) {
    Trimmer(points, ids, reach, surface, context).run();
    drop_unused_vertices(surface);
}

}  // namespace pointbake
