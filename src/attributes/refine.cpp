// Orientation by the surface's outward side; then areas and tangent axes from each point's cell
// among its neighbours, as the k nearest ones fill a round ball and say nothing about the spacing
// along and across scan lines.
#include <algorithm>
#include <cmath>

#include "attributes/spacing.h"
#include "attributes/spanning_tree.h"
#include "attributes/surface_ring.h"
#include "attributes/tangent_cell.h"
#include "core/bvh.h"
#include "core/kdtree.h"
#include "core/kernel.h"
#include "core/message.h"
#include "core/parallel.h"
#include "pointbake/attributes.h"

namespace pointbake {
namespace {

constexpr std::size_t kGrain = 2048;  // points per chunk: about a millisecond

// Axes are filled only where at least half the points have a cell more stretched than this. Cells
// of random points reach it by chance, but not half of them.
constexpr double kStretchedCell = 2.0;
constexpr double kMostStretched = 6.0;  // longer ellipses than that say more than a cell can know

/// The direction that is outward at each point; zero = not told.
using Sides = std::vector<Vec3f>;

Vec3f direction(Vec3d v) { return vec_cast<float>(normalized(v)); }

/// The side of each vertex is that of its triangles; points that are no vertices take the side of
/// the nearest one.
Sides sides_of_vertices(const PointCloud& cloud, const SurfaceRings& rings,
                        const Context& context) {
    Sides sides(cloud.size());
    parallel_for(context, cloud.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            sides[i] = direction(rings.outward(static_cast<Index>(i)));
    });
    std::vector<Index> with, without;
    for (Index i = 0; i < cloud.size(); ++i) (sides[i] != Vec3f{} ? with : without).push_back(i);
    if (with.empty() || without.empty()) return sides;
    std::vector<Vec3d> positions;
    positions.reserve(with.size());
    for (const Index i : with) positions.push_back(cloud.positions[i]);
    const KdTree tree(positions);
    parallel_for(context, without.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
            Neighbor nearest;
            tree.nearest(cloud.positions[without[k]], std::span(&nearest, 1));
            sides[without[k]] = sides[with[nearest.index]];
        }
    });
    return sides;
}

void set_area(PointCloud& cloud, std::size_t i, double area) {
    const bool is_estimated = cloud.radii[i] == equivalent_spacing(cloud.areas[i]);
    cloud.areas[i] = static_cast<float>(area);
    if (is_estimated) cloud.radii[i] = equivalent_spacing(cloud.areas[i]);
}

/// For a surface that does not come from the cloud: the normal of the closest triangle.
Sides sides_of_closest_triangles(const PointCloud& cloud, const Mesh& mesh,
                                 const Context& context) {
    const TriangleBvh bvh(mesh.positions, mesh.triangles);
    Sides sides(cloud.size());
    parallel_for(context, cloud.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const auto closest = bvh.closest(cloud.positions[i]);
            if (!closest) continue;
            const Triangle& t = mesh.triangles[closest->triangle];
            const Vec3d a = mesh.positions[t[0]];
            sides[i] = direction(cross(mesh.positions[t[1]] - a, mesh.positions[t[2]] - a));
        }
    });
    return sides;
}

struct OrientCounts {
    std::uint64_t num_flipped = 0, num_filled = 0;
};

/// Turns normals to their side; unknown ones become it.
OrientCounts orient_in_place(std::vector<Vec3f>& normals, const Sides& sides,
                             const Context& context) {
    const auto orient = [&](std::size_t begin, std::size_t end) {
        OrientCounts counts;
        for (std::size_t i = begin; i < end; ++i) {
            if (normals[i] == Vec3f{}) {
                normals[i] = sides[i];
                counts.num_filled += sides[i] == Vec3f{} ? 0U : 1U;
            } else if (dot(vec_cast<double>(normals[i]), vec_cast<double>(sides[i])) < 0.0) {
                normals[i] = -normals[i];
                ++counts.num_flipped;
            }
        }
        return counts;
    };
    const auto add = [](OrientCounts a, OrientCounts b) {
        return OrientCounts{a.num_flipped + b.num_flipped, a.num_filled + b.num_filled};
    };
    return parallel_reduce(context, normals.size(), kGrain, OrientCounts{}, orient, add);
}

struct Stretch {
    double ratio = 1.0;  ///< spacing along u over spacing across
    Vec3d u, v;          ///< orthonormal, in the tangent plane
};

/// Square roots of a cell's second moments are as the spacings.
Stretch stretch_of(const TangentCell& cell) {
    const double a = cell.uu, b = cell.uv, c = cell.vv;
    const double mean = 0.5 * (a + c), half = 0.5 * (a - c);
    const double r = std::sqrt(half * half + b * b);
    if (!(r > 0.0)) return {1.0, cell.u, cell.v};
    const Vec2d axis = half >= 0.0 ? Vec2d{half + r, b} : Vec2d{b, r - half};
    const Vec2d unit = axis / length(axis);
    const double largest = mean + r, smallest = mean - r;
    const double ratio = smallest * kMostStretched * kMostStretched > largest
                             ? std::sqrt(largest / smallest)
                             : kMostStretched;
    return {ratio, cell.u * unit.x + cell.v * unit.y, cell.v * unit.x - cell.u * unit.y};
}

/// Areas of all points; axes, if the points are clearly denser one way than the other.
void measure_cells_in_place(PointCloud& cloud, const Context& context) {
    const KdTree tree(cloud.positions);
    std::vector<double> areas(cloud.size());
    std::vector<TangentAxes> axes(cloud.size());
    const auto measure = [&](std::size_t begin, std::size_t end) {
        std::size_t num_stretched = 0;
        for (std::size_t i = begin; i < end; ++i) {
            const TangentCell cell = tangent_cell(cloud, static_cast<Index>(i), tree);
            areas[i] = cell.area;
            const Stretch s = stretch_of(cell);
            axes[i].u =
                vec_cast<float>(s.u * (double{kSplatSigma} * std::sqrt(cell.area * s.ratio)));
            axes[i].v =
                vec_cast<float>(s.v * (double{kSplatSigma} * std::sqrt(cell.area / s.ratio)));
            num_stretched += s.ratio > kStretchedCell ? 1U : 0U;
        }
        return num_stretched;
    };
    const auto add = [](std::size_t a, std::size_t b) { return a + b; };
    const std::size_t num_stretched =
        parallel_reduce(context, cloud.size(), kGrain, std::size_t{0}, measure, add);
    for (std::size_t i = 0; i < cloud.size(); ++i)
        if (areas[i] > 0.0) set_area(cloud, i, areas[i]);
    if (cloud.axes.empty() && 2 * num_stretched >= cloud.size()) cloud.axes = std::move(axes);
}

OrientCounts refine_by_surface_in_place(PointCloud& cloud, const DenseMesh& surface,
                                        const Context& context) {
    if (surface.vertex_points.empty())
        return orient_in_place(cloud.normals,
                               sides_of_closest_triangles(cloud, surface.mesh, context), context);
    const SurfaceRings rings(surface, cloud.size());
    const OrientCounts counts =
        orient_in_place(cloud.normals, sides_of_vertices(cloud, rings, context), context);
    measure_cells_in_place(cloud, context);
    return counts;
}

}  // namespace

AttributesResult refine_attributes(PointCloud cloud, const DenseMesh& surface,
                                   const AttributesOptions& options, const Context& context) {
    const std::size_t n = cloud.size();
    if (cloud.normals.size() != n || cloud.areas.size() != n || cloud.radii.size() != n)
        cloud = estimate_attributes(std::move(cloud), options, context).cloud;
    check_cancelled(context);
    report_progress(context, "orientation", 0.0);
    AttributesResult result{std::move(cloud), {}};

    result.report.oriented_by_surface = !surface.mesh.triangles.empty();
    if (result.report.oriented_by_surface) {
        const OrientCounts counts = refine_by_surface_in_place(result.cloud, surface, context);
        result.report.num_flipped_normals = counts.num_flipped;
        result.report.num_estimated_normals = counts.num_filled;
    } else {
        result.report.num_flipped_normals = orient_by_spanning_tree_in_place(result.cloud, context);
        result.cloud.given_normals.clear();  // their signs are the tree's now
    }

    const auto& normals = result.cloud.normals;
    result.report.num_invalid_normals =
        static_cast<std::uint64_t>(std::count(normals.begin(), normals.end(), Vec3f{}));
    result.report.median_spacing = median_spacing(result.cloud.areas);
    report_progress(context, "orientation", 1.0);
    return result;
}

}  // namespace pointbake
