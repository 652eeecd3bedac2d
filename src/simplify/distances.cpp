#include "simplify/distances.h"

#include <algorithm>
#include <cmath>

#include "core/bvh.h"
#include "core/parallel.h"

namespace pointbake {
namespace {

constexpr std::size_t kGrain = 1024;
// About this many samples over the mesh, so many per triangle of the surface; each triangle of the
// mesh has one at least.
constexpr double kMaxSamples = 20000.0;
constexpr double kSamplesPerTriangle = 2.0;
// Splits of a triangle's edges; a needle needs many, its area few.
constexpr int kMaxSplits = 64;
// The farthest point of a triangle from its centroid is a corner, at most 2/3 of a median and so of
// the longest edge away.
constexpr double kSlack = 2.0 / 3.0;

struct Sums {
    double weight = 0.0, first = 0.0, second = 0.0, max = 0.0;
    void add(double d, double w) {
        weight += w;
        first += w * d;
        second += w * d * d;
    }
    DistanceStats stats() const {
        if (!(weight > 0.0)) return {0.0, 0.0, max};
        return {first / weight, std::sqrt(second / weight), max};
    }
};
Sums combine(Sums a, const Sums& b) {
    a.weight += b.weight;
    a.first += b.first;
    a.second += b.second;
    a.max = std::max(a.max, b.max);
    return a;
}

double area_of(const Mesh& mesh, const Triangle& t) {
    const Vec3d a = mesh.positions[t[0]];
    return 0.5 * length(cross(mesh.positions[t[1]] - a, mesh.positions[t[2]] - a));
}

// Samples at the centroids of n^2 equal parts.
void sample_triangle(const std::array<Vec3d, 3>& x, double area, double spacing,
                     const TriangleBvh& surface, Sums& sums) {
    double longest = 0.0;
    for (std::size_t k = 0; k < 3; ++k) longest = std::max(longest, length(x[(k + 1) % 3] - x[k]));
    const int n =
        static_cast<int>(std::clamp(std::ceil(longest / spacing), 1.0, double{kMaxSplits}));
    const double step = 1.0 / n, slack = kSlack * longest * step;
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
            // Part (i, j) of the parallelogram lattice; those beyond the diagonal point downwards.
            const bool is_up = i + j < n;
            const double u = (is_up ? i + 1.0 / 3.0 : n - i - 1.0 / 3.0) * step;
            const double v = (is_up ? j + 1.0 / 3.0 : n - j - 1.0 / 3.0) * step;
            const Vec3d p = x[0] + (x[1] - x[0]) * u + (x[2] - x[0]) * v;
            const auto near = surface.closest(p);
            const double d = near ? std::sqrt(near->squared_distance) : HUGE_VAL;
            sums.add(d, area * step * step);
            sums.max = std::max(sums.max, d + slack);
        }
    }
}

}  // namespace

DistanceStats mesh_to_surface(const Mesh& mesh, const Mesh& surface, const Context& context) {
    if (mesh.triangles.empty() || surface.triangles.empty()) return {};
    const TriangleBvh bvh(surface.positions, surface.triangles);
    double area = 0.0;
    for (const Triangle& t : mesh.triangles) area += area_of(mesh, t);
    const double num_samples =
        std::min(kMaxSamples, kSamplesPerTriangle * static_cast<double>(surface.triangles.size()));
    const double spacing = std::max(std::sqrt(2.0 * area / num_samples), 1e-300);
    return parallel_reduce(
               context, mesh.triangles.size(), kGrain / 16, Sums{},
               [&](std::size_t begin, std::size_t end) {
                   Sums sums;
                   for (std::size_t i = begin; i < end; ++i) {
                       const Triangle& t = mesh.triangles[i];
                       sample_triangle(
                           {mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]},
                           area_of(mesh, t), spacing, bvh, sums);
                   }
                   return sums;
               },
               combine)
        .stats();
}

DistanceStats summarize(std::span<const double> distances, const Context& context) {
    return parallel_reduce(
               context, distances.size(), kGrain, Sums{},
               [&](std::size_t begin, std::size_t end) {
                   Sums sums;
                   for (std::size_t i = begin; i < end; ++i) {
                       if (distances[i] < 0.0) continue;
                       sums.add(distances[i], 1.0);
                       sums.max = std::max(sums.max, distances[i]);
                   }
                   return sums;
               },
               combine)
        .stats();
}

}  // namespace pointbake
