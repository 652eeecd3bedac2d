// Layered depth cube sampling [Pfister00] with one of the three axes per triangle instead of all
// three and a reduction: the axis along which the triangle looks largest. Rasterisation is exact:
// projected vertices are rounded to 1/1024 of the spacing and then integers decide.
#include "sample/ray_grid.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/parallel.h"

namespace pointbake {
namespace {

// Steps per spacing. Coordinates below 2^20 spacings then have 30 bits and edge functions 62.
constexpr std::int64_t kSubsteps = 1024;
constexpr std::size_t kGrain = 512;  // triangles per chunk

// The sum of the areas depends on how the grid falls on the borders of flat parts. Spacings around
// the first guess are tried until the sum is within the tolerance. A square of n points repeats its
// error when the spacing changes by the share 1 / sqrt(n): over all trials, a cube's sides by once.
constexpr int kTrials = 24;
constexpr double kTrialReach = 1.25;  // times 1 / sqrt(points), to either side
constexpr double kAreaTolerance = 1e-4;

std::int64_t floor_div(std::int64_t a, std::int64_t b) {
    return a / b - (a % b != 0 && (a < 0) != (b < 0) ? 1 : 0);
}
std::int64_t ceil_div(std::int64_t a, std::int64_t b) { return -floor_div(-a, b); }

struct Corner {
    std::int64_t x = 0, y = 0;
};

/// Twice the signed area of (a, b, p).
std::int64_t edge_function(Corner a, Corner b, Corner p) {
    return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
}

struct Range {
    std::int64_t first = 0, last = -1;
};

/// A triangle seen along its dominant axis, counter-clockwise.
struct Projected {
    std::array<Corner, 3> corners;
    bool is_mirrored = false;  ///< corners 1 and 2 are exchanged
    std::int64_t area2 = 0;
};

/// Leaves of [first, last] the rays on the inner side of the edge from a to b in the row at y. Rays
/// on the edge itself belong to it if it runs down, or leftwards: of the two triangles at an edge,
/// one.
void clip(Range& range, Corner a, Corner b, std::int64_t y) {
    const std::int64_t dx = b.x - a.x, dy = b.y - a.y;
    const std::int64_t least = dy < 0 || (dy == 0 && dx < 0) ? 0 : 1;
    const std::int64_t across = dx * (y - a.y);
    if (dy == 0) {
        if (across < least) range.last = range.first - 1;
        return;
    }
    // across - dy (x - a.x) >= least with x = kSubsteps i + kSubsteps / 2
    const std::int64_t rest = least - across - dy * (a.x - kSubsteps / 2);
    if (dy < 0)
        range.first = std::max(range.first, ceil_div(rest, -dy * kSubsteps));
    else
        range.last = std::min(range.last, floor_div(-rest, dy * kSubsteps));
}

/// Calls hit(range of rays, y in substeps) for each row of rays that meets the triangle.
template <class Hit>
void for_each_row(const Projected& p, Hit&& hit) {
    const auto [a, b, c] = p.corners;
    const std::int64_t low = std::min({a.y, b.y, c.y}), high = std::max({a.y, b.y, c.y});
    const std::int64_t left = std::min({a.x, b.x, c.x}), right = std::max({a.x, b.x, c.x});
    const std::int64_t half = kSubsteps / 2;
    const std::int64_t last_row = floor_div(high - half, kSubsteps);
    for (std::int64_t j = ceil_div(low - half, kSubsteps); j <= last_row; ++j) {
        const std::int64_t y = j * kSubsteps + half;
        Range range{ceil_div(left - half, kSubsteps), floor_div(right - half, kSubsteps)};
        clip(range, a, b, y);
        clip(range, b, c, y);
        clip(range, c, a, y);
        if (range.first <= range.last) hit(range, y);
    }
}

/// A mesh under a grid of rays with a given spacing.
class RayGrid {
 public:
    RayGrid(const Mesh& mesh, Vec3d origin, double spacing)
        : mesh_(mesh), origin_(origin), spacing_(spacing) {}

    struct Count {
        std::uint64_t num_samples = 0;
        double area = 0.0;
    };
    Count count(const Context& context) const {
        const auto of_range = [&](std::size_t begin, std::size_t end) {
            Count sum;
            for (std::size_t t = begin; t < end; ++t) {
                const auto n = count_of(static_cast<Index>(t));
                sum.num_samples += n;
                if (n > 0)
                    sum.area += static_cast<double>(n) * area_per_sample(static_cast<Index>(t));
            }
            return sum;
        };
        const auto add = [](Count a, Count b) {
            return Count{a.num_samples + b.num_samples, a.area + b.area};
        };
        return parallel_reduce(context, mesh_.triangles.size(), kGrain, Count{}, of_range, add);
    }

    std::vector<SurfaceSample> samples(const Context& context) const {
        const std::size_t num_chunks = (mesh_.triangles.size() + kGrain - 1) / kGrain;
        std::vector<std::vector<SurfaceSample>> parts(num_chunks);
        parallel_for(context, mesh_.triangles.size(), kGrain,
                     [&](std::size_t begin, std::size_t end) {
                         for (std::size_t t = begin; t < end; ++t)
                             append(static_cast<Index>(t), parts[begin / kGrain]);
                     });
        std::vector<SurfaceSample> all;
        for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
        return all;
    }

 private:
    std::int64_t to_grid(Vec3d p, std::size_t axis) const {
        const double steps = (p[axis] - origin_[axis]) / spacing_ * static_cast<double>(kSubsteps);
        return static_cast<std::int64_t>(std::floor(steps + 0.5));
    }

    std::optional<Projected> project(Index triangle) const {
        const Vec3d normal = TriangleFrame(mesh_, triangle).normal();
        if (!(squared_length(normal) > 0.0)) return std::nullopt;
        const std::size_t axis = dominant_axis(normal);
        Projected p;
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3d corner = mesh_.positions[mesh_.triangles[triangle][k]];
            p.corners[k] = {to_grid(corner, (axis + 1) % 3), to_grid(corner, (axis + 2) % 3)};
        }
        p.area2 = edge_function(p.corners[0], p.corners[1], p.corners[2]);
        if (p.area2 == 0) return std::nullopt;
        if (p.area2 < 0) {
            std::swap(p.corners[1], p.corners[2]);
            p.area2 = -p.area2;
            p.is_mirrored = true;
        }
        return p;
    }

    double area_per_sample(Index triangle) const {
        const Vec3d normal = TriangleFrame(mesh_, triangle).normal();
        return spacing_ * spacing_ * length(normal) / std::fabs(normal[dominant_axis(normal)]);
    }

    std::uint64_t count_of(Index triangle) const {
        std::int64_t sum = 0;
        if (const auto p = project(triangle))
            for_each_row(*p, [&](Range r, std::int64_t) { sum += r.last - r.first + 1; });
        return static_cast<std::uint64_t>(sum);
    }

    void append(Index triangle, std::vector<SurfaceSample>& out) const {
        const auto p = project(triangle);
        if (!p) return;
        const auto area = static_cast<float>(area_per_sample(triangle));
        const auto [a, b, c] = p->corners;
        const double scale = 1.0 / static_cast<double>(p->area2);
        for_each_row(*p, [&](Range r, std::int64_t y) {
            for (std::int64_t i = r.first; i <= r.last; ++i) {
                const Corner ray{i * kSubsteps + kSubsteps / 2, y};
                double u = static_cast<double>(edge_function(c, a, ray)) * scale;
                double v = static_cast<double>(edge_function(a, b, ray)) * scale;
                if (p->is_mirrored) std::swap(u, v);
                out.push_back({triangle, area, u, v});
            }
        });
    }

    const Mesh& mesh_;
    Vec3d origin_;
    double spacing_;
};

}  // namespace

RayGridSamples sample_on_ray_grid(const Mesh& mesh, std::uint64_t count, const Context& context) {
    Box box;
    double projected = 0.0, area = 0.0;
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        const TriangleFrame frame(mesh, t);
        const Vec3d n = frame.normal();
        projected += 0.5 * std::max({std::fabs(n.x), std::fabs(n.y), std::fabs(n.z)});
        area += 0.5 * length(n);
        for (const Vec3d p : {frame.a, frame.at(1.0, 0.0), frame.at(0.0, 1.0)}) box.extend(p);
    }

    const double guess = std::sqrt(projected / static_cast<double>(count));
    const double step = 2.0 * kTrialReach / (kTrials * std::sqrt(static_cast<double>(count)));
    double best_spacing = guess, best_error = HUGE_VAL;
    for (int trial = 0; trial < kTrials && best_error > kAreaTolerance * area; ++trial) {
        const int steps = trial % 2 == 0 ? trial / 2 : -(trial + 1) / 2;
        const double spacing = guess * std::max(0.5, 1.0 + steps * step);
        const double error = std::fabs(RayGrid(mesh, box.low, spacing).count(context).area - area);
        if (error >= best_error) continue;
        best_error = error;
        best_spacing = spacing;
    }
    return {best_spacing, RayGrid(mesh, box.low, best_spacing).samples(context)};
}

}  // namespace pointbake
