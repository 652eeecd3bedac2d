#include "reconstruct/reach.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/parallel.h"

namespace pointbake {
namespace {

constexpr std::size_t kRank = 12;
// A triangle is looked at in steps of so many spacings along each side; what lies between two of
// these places may be a little farther away than they are.
constexpr double kStep = 0.3, kBetween = 0.93;
constexpr int kMostSteps = 32;
// Triangles with no part farther than so many spacings (Delaunay neighbours' distances, which are
// the larger ones) from a corner need no look.
constexpr double kSurelyNear = 1.0;
constexpr std::size_t kGrain = 1U << 10;

// Most distance from a place in the triangle to the nearest corner, squared.
double farthest_from_corners2(Vec3d a, Vec3d b, Vec3d c) {
    std::array<double, 3> sides{squared_length(b - a), squared_length(c - b),
                                squared_length(a - c)};
    std::sort(sides.begin(), sides.end());
    if (sides[0] + sides[1] <= sides[2]) return 0.25 * sides[2];
    return sides[0] * sides[1] * sides[2] / (4.0 * squared_length(cross(b - a, c - a)));
}

}  // namespace

double Reach::spacing(Index point) const {
    std::array<Neighbor, kRank + 1> buffer;
    const auto found = tree_.nearest(points_[point], buffer);
    return std::sqrt(std::numbers::pi * found.back().squared_distance /
                     static_cast<double>(std::max<std::size_t>(found.size() - 1, 1)));
}

// Where points become denser all of a sudden, those of a corner count, up to kDenser times.
bool Reach::holds(Vec3d x, double corner_spacing) const {
    Neighbor nearest;
    tree_.nearest(x, std::span(&nearest, 1));
    const double own = spacing(nearest.index);
    const double local = std::max(own, std::min(corner_spacing, kDenser * own));
    const double reach = kBetween * kFarthest * local;
    return nearest.squared_distance <= reach * reach;
}

bool Reach::holds(Vec3d a, Vec3d b, Vec3d c) const {
    double least = HUGE_VAL, largest = 0.0;
    for (const Vec3d x : {a, b, c}) {
        Neighbor nearest;
        tree_.nearest(x, std::span(&nearest, 1));
        const double own = spacing(nearest.index);
        least = std::min(least, own), largest = std::max(largest, own);
    }
    const double step = kStep * least;
    const double longest =
        std::sqrt(std::max({squared_length(b - a), squared_length(c - b), squared_length(a - c)}));
    const int steps =
        step * kMostSteps > longest ? static_cast<int>(longest / step) + 1 : kMostSteps;
    for (int i = 0; i <= steps; ++i)
        for (int k = 0; i + k <= steps; ++k)
            if (!holds(a + (b - a) * (double(i) / steps) + (c - a) * (double(k) / steps), largest))
                return false;
    return true;
}

void drop_far_facets(const Tetrahedra& tets, std::span<const float> spacing,
                     std::span<const Vec3d> points, const Reach& reach, FacetSurface& surface,
                     const Context& context) {
    std::vector<std::uint8_t> is_far(surface.facets.size(), 0);
    parallel_for(context, is_far.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t t = begin; t < end; ++t) {
            const auto [a, b, c] = tets.triangle(surface.facets[t]);
            const double near = kSurelyNear * std::min({spacing[a], spacing[b], spacing[c]});
            if (farthest_from_corners2(tets.points[a], tets.points[b], tets.points[c]) <=
                near * near)
                continue;
            const auto& ids = tets.point_ids;
            is_far[t] = reach.holds(points[ids[a]], points[ids[b]], points[ids[c]]) ? 0 : 1;
        }
    });
    drop_facets(is_far, surface);
}

}  // namespace pointbake
