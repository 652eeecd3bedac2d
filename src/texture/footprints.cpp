// [Zwicker01] with the local affine map of the prism instead of a camera: V = J J^T, J = d(x, y)/dp
// [a1 a2].
#include "texture/footprints.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/parallel.h"

namespace pointbake {
namespace {

constexpr std::size_t kGrain = 2048;
constexpr int kMaxWalk =
    12;  // triangles crossed from the nearest one to the prism that holds a point
constexpr double kInside = -1e-9;  // barycentrics this negative are rounding
constexpr double kMinFacing =
    0.17;  // cos 80 degrees: surfels seen more obliquely are another part of the surface
constexpr double kMaxStretch = 2.0;  // axes grow by more only where the prism degenerates
constexpr double kMinAxis = 0.1;     // of sigma: an edge-on surfel keeps this width
constexpr double kOrthogonalShare = 2.0 / 3.0;  // of the way from a foot to the orthogonal one
constexpr double kMostOfTheWay = 0.5;           // to the nearest side
constexpr double kMaxSigmaOverMedian = 8.0;     // larger ones belong to outliers

struct Placed {
    Index triangle = kInvalidIndex;
    Footprint footprint;
};

// The edge a point lies beyond most, or 3 if it lies inside.
std::size_t edge_to_cross(Vec3d b) {
    // Edge k runs from corner k to k+1, opposite to corner k+2.
    std::size_t edge = 3;
    double lowest = kInside;
    for (std::size_t k = 0; k < 3; ++k) {
        const double opposite = b[(k + 2) % 3];
        if (opposite < lowest) lowest = opposite, edge = k;
    }
    return edge;
}

double outside_amount(Vec3d b) { return std::max({0.0, -b.x, -b.y, -b.z}); }

// Walks from the nearest triangle to the one whose prism holds p; at borders of the surface the
// nearest miss.
ShellPoint find_prism(const Shell& shell, const std::vector<std::array<Index, 3>>& neighbors,
                      Vec3d p, Index& triangle) {
    ShellPoint best = shell.project(triangle, p);
    Index best_triangle = triangle, previous = kInvalidIndex;
    ShellPoint here = best;
    for (int step = 0; step < kMaxWalk; ++step) {
        const std::size_t edge = edge_to_cross(here.barycentric);
        if (edge == 3) break;
        const Index next = neighbors[triangle][edge];
        if (next == kInvalidIndex || next == previous) break;
        previous = triangle;
        triangle = next;
        here = shell.project(triangle, p);
        if (outside_amount(here.barycentric) < outside_amount(best.barycentric)) {
            best = here, best_triangle = triangle;
        }
    }
    triangle = best_triangle;
    return best;
}

// Two axes of a circular surfel in its tangent plane.
TangentAxes circular_axes(Vec3d n, double sigma) {
    const Vec3d helper = std::fabs(n.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
    const Vec3d u = normalized(cross(helper, n));
    return {vec_cast<float>(u * sigma), vec_cast<float>(cross(n, u) * sigma)};
}

// Distance of a place within the triangle to its nearest side; 0 outside.
double distance_to_sides(const TriangleFrame& frame, Vec2d x) {
    double distance = HUGE_VAL;
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec2d a = frame.corners[k], side = frame.corners[(k + 1) % 3] - a;
        distance = std::min(distance, cross(side, x - a) / length(side));
    }
    return std::max(distance, 0.0);
}

// Where on the triangle a point is painted, and how a small step in space moves that place.
struct Foot {
    Vec2d place;
    std::array<Vec3d, 2> gradient;
};

// Viewers who look along a triangle see little of it. So what is seen of a point lies, in the mean,
// nearer to its orthogonal foot than to its foot along the interpolated normal. It is moved that
// way, but never out of its triangle: prisms still share their walls, and the paint stays whole.
Foot painted_foot(const ShellPoint& at, const TriangleFrame& frame, Vec3d p) {
    Vec2d x{};
    for (std::size_t k = 0; k < 3; ++k) x = x + frame.corners[k] * at.barycentric[k];
    const Vec3d d = p - frame.origin;
    const Vec2d way = Vec2d{dot(frame.ex, d), dot(frame.ey, d)} - x;
    const double distance = length(way);
    if (!(distance > 0.0)) return {x, at.gradient};
    const double share =
        std::min(kOrthogonalShare, kMostOfTheWay * distance_to_sides(frame, x) / distance);
    return {x + way * share,
            {at.gradient[0] * (1.0 - share) + frame.ex * share,
             at.gradient[1] * (1.0 - share) + frame.ey * share}};
}

Footprint make_footprint(const PointCloud& cloud, Index point, const ShellPoint& at,
                         const TriangleFrame& frame, double sigma) {
    Vec3d n = cloud.normals.empty() ? at.direction : vec_cast<double>(cloud.normals[point]);
    const bool has_normal = squared_length(n) > 0.0;
    if (!has_normal) n = at.direction;
    const TangentAxes axes = cloud.axes.empty() ? circular_axes(n, sigma) : cloud.axes[point];

    Footprint f;
    f.point = point;
    f.depth = static_cast<float>(at.depth);
    f.hidden = dot(n, at.direction) < kMinFacing;
    const Foot foot = painted_foot(at, frame, cloud.positions[point]);
    f.center = {static_cast<float>(foot.place.x), static_cast<float>(foot.place.y)};

    double vxx = 0.0, vxy = 0.0, vyy = 0.0;
    for (const Vec3f& axis : {axes.u, axes.v}) {
        const Vec3d a = vec_cast<double>(axis);
        const double jx = dot(foot.gradient[0], a), jy = dot(foot.gradient[1], a);
        vxx += jx * jx, vxy += jx * jy, vyy += jy * jy;
    }
    // A degenerate prism may blow an axis up: then the circle in the plane stands in.
    const double limit = kMaxStretch * kMaxStretch *
                         std::max(squared_length(vec_cast<double>(axes.u)),
                                  squared_length(vec_cast<double>(axes.v)));
    if (!(vxx + vyy <= 2.0 * limit)) vxx = vyy = sigma * sigma, vxy = 0.0;
    const double floor = kMinAxis * kMinAxis * sigma * sigma;
    f.vxx = static_cast<float>(vxx + floor);
    f.vxy = static_cast<float>(vxy);
    f.vyy = static_cast<float>(vyy + floor);
    return f;
}

double median_sigma(const PointCloud& cloud, double kernel_sigma) {
    std::vector<float> areas = cloud.areas;
    if (areas.empty()) return 0.0;
    const auto middle = areas.begin() + static_cast<std::ptrdiff_t>(areas.size() / 2);
    std::nth_element(areas.begin(), middle, areas.end());
    return kernel_sigma * std::sqrt(static_cast<double>(*middle));
}

// Largest splat radius per triangle, spread over the mesh until triangles without points know one,
// too.
std::vector<float> spread_reach(const Footprints& prints,
                                const std::vector<std::array<Index, 3>>& neighbors,
                                std::size_t num_triangles, float cut) {
    std::vector<float> reach(num_triangles, 0.0F);
    for (Index t = 0; t < num_triangles; ++t) {
        for (const Footprint& f : prints.of(t)) {
            const float mean = 0.5F * (f.vxx + f.vyy), half = 0.5F * (f.vxx - f.vyy);
            const float largest = mean + std::sqrt(half * half + f.vxy * f.vxy);
            reach[t] = std::max(reach[t], cut * std::sqrt(largest));
        }
    }
    constexpr int kRounds = 3;  // far enough: further neighbours' splats do not get here
    for (int round = 0; round < kRounds; ++round) {
        std::vector<float> next = reach;
        for (Index t = 0; t < num_triangles; ++t) {
            for (Index n : neighbors[t]) {
                if (n != kInvalidIndex) next[t] = std::max(next[t], reach[n]);
            }
        }
        reach.swap(next);
    }
    return reach;
}

}  // namespace

Footprints project_points(const Mesh& mesh, const PointCloud& cloud, std::span<const Index> owners,
                          const Shell& shell, const std::vector<std::array<Index, 3>>& neighbors,
                          const Kernel& kernel, const Context& context) {
    const auto kernel_sigma = static_cast<double>(kernel.sigma);
    const std::size_t num_points = cloud.size(), num_triangles = mesh.triangles.size();
    const double max_sigma = kMaxSigmaOverMedian * median_sigma(cloud, kernel_sigma);
    std::vector<Placed> placed(num_points);
    parallel_for(context, num_points, kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (owners[i] == kInvalidIndex) continue;
            Placed& out = placed[i];
            out.triangle = owners[i];
            const ShellPoint at = find_prism(shell, neighbors, cloud.positions[i], out.triangle);
            const double sigma =
                std::min(max_sigma, kernel_sigma * std::sqrt(static_cast<double>(cloud.areas[i])));
            out.footprint =
                make_footprint(cloud, static_cast<Index>(i), at, shell.frame(out.triangle), sigma);
        }
    });

    // Counting sort by triangle keeps the points' order within each.
    Footprints prints;
    prints.begin.assign(num_triangles + 1, 0);
    for (const Placed& p : placed) {
        if (p.triangle != kInvalidIndex) ++prints.begin[p.triangle + 1];
    }
    std::partial_sum(prints.begin.begin(), prints.begin.end(), prints.begin.begin());
    prints.items.resize(prints.begin.back());
    std::vector<Index> next(prints.begin.begin(), prints.begin.end() - 1);
    for (const Placed& p : placed) {
        if (p.triangle != kInvalidIndex) prints.items[next[p.triangle]++] = p.footprint;
    }
    prints.reach = spread_reach(prints, neighbors, num_triangles, kernel.cut);
    return prints;
}

}  // namespace pointbake
