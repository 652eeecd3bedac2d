// Based on [Dey06]: big Delaunay balls on the two sides of a noisy sheet hardly intersect, those on
// one side do so deeply. Departure: where the facet between two balls is itself large, there is a
// way through however they intersect, as at the mouth of a cup.
#include "reconstruct/robust_cocone.h"

#include <algorithm>

#include "core/parallel.h"
#include "reconstruct/circumcenter.h"

namespace pointbake {
namespace {

// A ball is big if its radius is more than this many times the spacing at each of its points, a
// facet is the mouth of something if its radius is. Found on 200 000 random points, where one leak
// is enough to let the flood in: 2 leaks at some noise for either, these at none.
constexpr double kBig = 2.5, kMouth = 3.0;
// Cosine of the largest angle between balls that intersect deeply: 45 degrees. 90 leak.
constexpr double kDeepCos = 0.70710678118654752;
constexpr std::size_t kGrain = 1U << 11;
constexpr std::size_t kPollInterval = 1U << 16;

class Flood {
 public:
    Flood(const Tetrahedra& tets, std::span<const float> spacing, const Context& context)
        : tets_(tets), spacing_(spacing), context_(context) {}

    std::vector<Index> run() {
        find_big();
        spread();
        return list_points();
    }

 private:
    void find_big() {
        is_big_.resize(tets_.num_cells());
        parallel_for(context_, is_big_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
            for (Index c = static_cast<Index>(begin); c < end; ++c) is_big_[c] = is_big(c) ? 1 : 0;
        });
    }

    // Squares, and no division by the volume.
    bool is_big(Index cell) const {
        if (tets_.has_far(cell)) return true;
        const Circumcenter center = circumcenter(tets_, cell);
        float spacing = 0.0F;
        for (Index v : tets_.cells[cell]) spacing = std::max(spacing, spacing_[v]);
        const double reach = kBig * spacing * center.den;
        return squared_length(center.num) > reach * reach;
    }

    // From all cells at far points.
    void spread() {
        is_outside_.assign(tets_.num_cells(), 0);
        std::vector<Index> queue;
        for (Index c = 0; c < tets_.num_cells(); ++c) {
            if (!tets_.has_far(c)) continue;
            is_outside_[c] = 1;
            queue.push_back(c);
        }
        for (std::size_t head = 0; head < queue.size(); ++head) {
            if (head % kPollInterval == 0) check_cancelled(context_);
            const Index c = queue[head];
            for (Index i = 0; i < 4; ++i) {
                const Index n = tets_.neighbors[c][i];
                if (n == kInvalidIndex || is_outside_[n] != 0 || is_big_[n] == 0) continue;
                if (!intersect_deeply(c * 4 + i) && !is_mouth(c * 4 + i)) continue;
                is_outside_[n] = 1;
                queue.push_back(n);
            }
        }
    }

    // Of the balls on both sides of a facet: by the angle between their radii at a common point,
    // which is the same at all of them. On one side of a sheet the radii nearly agree, on two sides
    // they are nearly opposite.
    bool intersect_deeply(HalfFacet facet) const {
        const Index c = facet / 4, n = tets_.neighbors[c][facet % 4];
        const Vec3d p = tets_.points[tets_.triangle(facet)[0]];
        const Vec3d a = direction_to(tets_, c, circumcenter(tets_, c), p);
        const Vec3d b = direction_to(tets_, n, circumcenter(tets_, n), p);
        return dot(a, b) > kDeepCos * std::sqrt(squared_length(a) * squared_length(b));
    }

    bool is_mouth(HalfFacet facet) const {
        double spacing = 0.0;
        for (Index v : tets_.triangle(facet)) {
            if (tets_.is_far(v)) return true;
            spacing = std::max(spacing, double{spacing_[v]});
        }
        return circumradius2(tets_, facet) > kMouth * kMouth * spacing * spacing;
    }

    std::vector<Index> list_points() const {
        std::vector<std::uint8_t> is_outer(tets_.points.size(), 0);
        for (Index c = 0; c < tets_.num_cells(); ++c)
            if (is_outside_[c] != 0)
                for (Index v : tets_.cells[c]) is_outer[v] = 1;
        std::vector<Index> points;
        for (Index v = 0; v < tets_.num_real(); ++v)
            if (is_outer[v] != 0) points.push_back(v);
        return points;
    }

    const Tetrahedra& tets_;
    std::span<const float> spacing_;
    const Context& context_;
    std::vector<std::uint8_t> is_big_, is_outside_;
};

}  // namespace

std::vector<Index> outer_points(const Tetrahedra& tets, std::span<const float> spacing,
                                const Context& context) {
    return Flood(tets, spacing, context).run();
}

}  // namespace pointbake
