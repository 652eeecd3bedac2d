// Quadrics of planes [Garland97], weighted by area so that the tessellation does not matter: the
// cost is the squared distance integrated over the surface that a vertex stands for. Departs from
// it by a regularised placement.
#include "simplify/ordering.h"

#include <algorithm>

#include "core/parallel.h"

namespace pointbake {
namespace {

// Weight of the plane that stands on a boundary edge, times the edge's squared length. Areas of
// triangles are about 0.4 of that, so a boundary is ten times as stiff as a surface.
constexpr double kBoundaryWeight = 4.0;
// Pull towards the edge's midpoint, as a share of the quadric's mean eigenvalue: below this ratio
// of curvatures a direction counts as flat.
constexpr double kPlacementPull = 1e-4;
// Each step cuts the pull's bias in a stiff direction by its ratio: three leave 1e-12 of it.
constexpr int kPlacementSteps = 3;
// A vertex farther than this many edge lengths from the edge's midpoint is a wild solution.
constexpr double kMaxPlacement = 1.0;
// Where the surface is flat the errors vanish: short edges first keeps triangles round. As a share
// of the error that the edge's length would make across the surface.
constexpr double kLengthShare = 1e-6;
constexpr std::size_t kVertexGrain = 2048;

}  // namespace

CollapseOrder::CollapseOrder(const Surface& surface, const Context& context)
    : surface_(surface), quadrics_(surface.positions.size()) {
    parallel_for(context, quadrics_.size(), kVertexGrain, [&](std::size_t begin, std::size_t end) {
        std::vector<EdgeUse> edges;
        for (std::size_t i = begin; i < end; ++i) {
            const Index v = static_cast<Index>(i);
            surface_.for_each_corner(v, [&](Index c) {
                const auto [p, q, r] = surface_.corners_of(c / 3);
                const Vec3d n = cross(q - p, r - p);
                const double twice_area = length(n);
                if (twice_area > 0.0) quadrics_[i].add_plane(n / twice_area, p, 0.5 * twice_area);
            });
            if (surface_.kinds[i] == VertexKind::kInterior) continue;
            collect_edges(surface_, v, edges);
            add_boundary_planes(v, edges);
        }
    });
}

// For each triangle on a special edge at v: the plane through the edge, perpendicular to it.
void CollapseOrder::add_boundary_planes(Index v, const std::vector<EdgeUse>& edges) {
    const auto is_special = [&](Index w) {
        return std::any_of(edges.begin(), edges.end(),
                           [&](const EdgeUse& e) { return e.neighbor == w && e.is_special(); });
    };
    surface_.for_each_corner(v, [&](Index c) {
        const auto [p, q, r] = surface_.corners_of(c / 3);
        const Vec3d n = cross(q - p, r - p);
        for (Index w : {surface_.after(c), surface_.before(c)}) {
            if (!is_special(w)) continue;
            const Vec3d edge = surface_.positions[w] - surface_.positions[v];
            quadrics_[v].add_plane(normalized(cross(edge, n)), surface_.positions[v],
                                   kBoundaryWeight * squared_length(edge));
        }
    });
}

Vec3d CollapseOrder::placement(Index a, Index b, const Quadric& q) const {
    const VertexKind ka = surface_.kinds[a], kb = surface_.kinds[b];
    const Vec3d pa = surface_.positions[a], pb = surface_.positions[b];
    if (ka != kb) return ka > kb ? pa : pb;
    const Vec3d middle = (pa + pb) * 0.5;
    const Vec3d x = q.minimum_near(middle, kPlacementPull / 3.0 * q.trace(), kPlacementSteps);
    if (squared_length(x - middle) <= kMaxPlacement * kMaxPlacement * squared_length(pb - pa))
        return x;
    Vec3d best = middle;
    for (Vec3d candidate : {pa, pb}) {
        if (q(candidate) < q(best)) best = candidate;
    }
    return best;
}

Vec3d CollapseOrder::placement(Index a, Index b) const {
    Quadric q = quadrics_[a];
    q += quadrics_[b];
    return placement(a, b, q);
}

float CollapseOrder::cost(Index a, Index b) const {
    Quadric q = quadrics_[a];
    q += quadrics_[b];
    const double along = squared_length(surface_.positions[b] - surface_.positions[a]);
    return static_cast<float>(q(placement(a, b, q)) + kLengthShare * q.trace() * along);
}

}  // namespace pointbake
