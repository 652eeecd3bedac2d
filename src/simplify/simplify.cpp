// The stage from end to end: points are attributed, edges collapse, vertices are fitted, and the
// distances are measured. Decisions are made in coordinates relative to the surface's centre and
// scaled by a power of two to about unit size.
#include "pointbake/simplify.h"

#include <algorithm>
#include <cmath>

#include "core/bvh.h"
#include "core/message.h"
#include "core/parallel.h"
#include "simplify/attribution.h"
#include "simplify/collapse.h"
#include "simplify/distances.h"
#include "simplify/fit.h"
#include "simplify/removal.h"
#include "simplify/surface.h"

namespace pointbake {
namespace {

constexpr Length kDefaultBound = fraction(0.001);
// Kept free below the bound, as a share of the diagonal, for coordinates that become floats.
constexpr double kFloatMargin = 1e-7;
constexpr std::size_t kPointGrain = 2048;
// Progress when the points are attributed, the bounded collapses are done, all of them, and the
// vertices are fitted: shares of the time it took on scans.
constexpr double kPreparedShare = 0.1, kBoundedShare = 0.6, kCollapsedShare = 0.65,
                 kMeasuredShare = 0.9;

void validate(const DenseMesh& dense, const PointCloud& cloud, const SimplifyOptions& options) {
    validate(options);
    const std::size_t num_vertices = dense.mesh.positions.size();
    for (std::size_t t = 0; t < dense.mesh.triangles.size(); ++t) {
        for (Index v : dense.mesh.triangles[t]) {
            if (v >= num_vertices)
                fail(ErrorCode::kInvalidInput,
                     "triangle {} names vertex {}, but the mesh has {} vertices", t, v,
                     num_vertices);
        }
    }
    if (!dense.vertex_points.empty() && dense.vertex_points.size() != num_vertices)
        fail(ErrorCode::kInvalidInput, "{} vertices, but {} points under them", num_vertices,
             dense.vertex_points.size());
    for (Index p : dense.vertex_points) {
        if (p != kInvalidIndex && p >= cloud.size())
            fail(ErrorCode::kInvalidInput, "a vertex names point {}, but there are {} points", p,
                 cloud.size());
    }
}

// Coordinates in which decisions are made.
struct WorkingFrame {
    Vec3d origin;
    double unit = 1.0;  // a power of two, so scaling is exact

    explicit WorkingFrame(const Mesh& mesh) {
        Box box;
        for (const Triangle& t : mesh.triangles) {
            for (Index v : t) box.extend(mesh.positions[v]);
        }
        origin = box.center();
        int exponent = 0;
        std::frexp(box.diagonal(), &exponent);
        unit = std::ldexp(1.0, exponent);
    }
    Vec3d inwards(Vec3d p) const { return (p - origin) / unit; }
    Vec3d outwards(Vec3d p) const { return origin + p * unit; }
    std::vector<Vec3d> inwards(const std::vector<Vec3d>& points) const {
        std::vector<Vec3d> out(points.size());
        std::transform(points.begin(), points.end(), out.begin(),
                       [&](Vec3d p) { return inwards(p); });
        return out;
    }
};

double diagonal_of_kept(const std::vector<Vec3d>& points, const std::vector<double>& distances,
                        double limit) {
    Box box;
    for (std::size_t p = 0; p < points.size(); ++p) {
        if (distances[p] <= limit) box.extend(points[p]);
    }
    return box.diagonal();
}

// The bound in cloud units. As a share of the diagonal of the kept points it decides itself which
// points those are: it shrinks until that agrees. `distances` are in the frame's units.
double find_bound(const SimplifyOptions& options, const std::vector<Vec3d>& points,
                  const std::vector<double>& distances, double unit) {
    const std::optional<Length> length = bound_of(options);
    if (!length) return HUGE_VAL;
    double bound = length->in_units(diagonal_of_kept(points, distances, HUGE_VAL));
    for (;;) {
        const double next = length->in_units(diagonal_of_kept(points, distances, bound / unit));
        if (!(next < bound)) return bound;
        bound = next;
    }
}

// The surviving triangles and vertices in their old order.
FitMesh compact(const Surface& surface, const Attribution& attribution) {
    FitMesh out;
    std::vector<Index> new_vertices(surface.positions.size(), kInvalidIndex);
    for (Index v = 0; v < surface.positions.size(); ++v) {
        if (surface.first_corners[v] == kInvalidIndex) continue;
        new_vertices[v] = static_cast<Index>(out.positions.size());
        out.positions.push_back(surface.positions[v]);
        out.kinds.push_back(surface.kinds[v]);
    }
    out.owners.assign(attribution.points.size(), kInvalidIndex);
    for (Index t = 0; t < surface.triangles.size(); ++t) {
        if (surface.is_removed(t)) continue;
        const Triangle& v = surface.triangles[t];
        attribution.for_each_point(
            t, [&](Index p) { out.owners[p] = static_cast<Index>(out.triangles.size()); });
        out.triangles.push_back({new_vertices[v[0]], new_vertices[v[1]], new_vertices[v[2]]});
    }
    return out;
}

void add(CollapseCounts counts, SimplifyReport& report) {
    report.num_collapses += counts.num_collapses;
    report.num_rejected_by_bound += counts.num_rejected_by_bound;
    report.num_rejected_by_topology += counts.num_rejected_by_topology;
    report.num_rejected_by_shape += counts.num_rejected_by_shape;
    report.num_parts_removed += counts.num_parts_removed;
}

// Distances of the kept points to the whole mesh. A point changes its owner if another triangle is
// nearer and faces the same way.
void measure_points(const PointCloud& cloud, const Attribution& attribution,
                    std::vector<Index> owners, SimplifyResult& result, const Context& context) {
    const Mesh& mesh = result.mesh;
    const TriangleBvh bvh(mesh.positions, mesh.triangles);
    result.point_distances.assign(cloud.size(), 0.0F);
    std::vector<double> distances(cloud.size(), -1.0);
    const auto normal_of = [&](Index t) {
        const Vec3d a = mesh.positions[mesh.triangles[t][0]];
        return cross(mesh.positions[mesh.triangles[t][1]] - a,
                     mesh.positions[mesh.triangles[t][2]] - a);
    };
    parallel_for(context, cloud.size(), kPointGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t p = begin; p < end; ++p) {
            Index& owner = owners[p];
            if (owner == kInvalidIndex) continue;
            const Triangle& v = mesh.triangles[owner];
            const Vec3d x = cloud.positions[p];
            const double own =
                std::sqrt(closest_point_on_triangle(x, mesh.positions[v[0]], mesh.positions[v[1]],
                                                    mesh.positions[v[2]])
                              .squared_distance);
            const auto near = bvh.closest(x, own);
            distances[p] = near ? std::sqrt(near->squared_distance) : own;
            const Vec3d n = vec_cast<double>(attribution.normals[p]);
            const bool is_better =
                near && distances[p] < own && dot(n, normal_of(near->triangle)) >= 0.0;
            if (is_better) owner = near->triangle;
            result.point_distances[p] = static_cast<float>(is_better ? distances[p] : own);
        }
    });
    result.point_triangles = std::move(owners);
    result.report.points_to_mesh = summarize(distances, context);
}

// Triangles of the dense mesh that the surface took over, in its order.
std::vector<Index> taken_triangles(const Mesh& mesh) {
    std::vector<Index> out;
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        const Triangle& v = mesh.triangles[t];
        if (v[0] != v[1] && v[1] != v[2] && v[2] != v[0]) out.push_back(t);
    }
    return out;
}

// The mesh as it is: only the points are attributed.
void keep(const DenseMesh& dense, const Attribution& attribution, SimplifyResult& result,
          std::vector<Index>& owners) {
    result.mesh = dense.mesh;
    result.mesh.normals.clear();
    const std::vector<Index> taken = taken_triangles(dense.mesh);
    owners = attribution.owners;
    for (Index& t : owners) {
        if (t != kInvalidIndex) t = taken[t];
    }
}

// Collapses and fits until the limits are reached; returns the mesh in the frame's coordinates.
FitMesh make_light(Surface& surface, Attribution& attribution, const SimplifyOptions& options,
                   double limit, SimplifyReport& report, const Context& context) {
    CollapseLimits limits{options.triangles, limit * limit, kPreparedShare, kBoundedShare};
    add(collapse_edges_in_place(surface, attribution, limits, context), report);
    // A budget is never exceeded: where the bound stops the work too early, it is given up.
    if (options.triangles > 0 && surface.num_triangles > options.triangles && limit < HUGE_VAL) {
        limits = {options.triangles, HUGE_VAL, kBoundedShare, kCollapsedShare};
        add(collapse_edges_in_place(surface, attribution, limits, context), report);
        report.bound_met = false;
    }
    if (options.triangles > 0 && surface.num_triangles > options.triangles)
        report.num_parts_removed += drop_smallest_parts(surface, attribution, options.triangles);
    if (report.num_parts_removed > 0)
        log(context, LogLevel::kWarning,
            "{} triangles serve the surface best without its tiniest parts: {} left out",
            options.triangles, report.num_parts_removed);
    if (options.triangles > 0 && surface.num_triangles > options.triangles)
        fail(ErrorCode::kLimit,
             "{} triangles cannot hold this surface: its shape (holes, handles) needs {}",
             options.triangles, surface.num_triangles);
    drop_flat_triangles(surface, attribution);
    FitMesh light = compact(surface, attribution);
    report_progress(context, "simplify", kCollapsedShare);
    fit_in_place(light, attribution, limits.squared_distance, context);
    return light;
}

}  // namespace

std::optional<Length> bound_of(const SimplifyOptions& options) {
    if (options.geometry_error || options.triangles > 0 || options.keep_mesh)
        return options.geometry_error;
    return kDefaultBound;
}

void validate(const SimplifyOptions& options) {
    if (options.geometry_error &&
        !(options.geometry_error->value > 0.0 && std::isfinite(options.geometry_error->value)))
        fail(ErrorCode::kInvalidOption,
             "geometry-error is {}: it must be a positive length such as 0.1%, 0.002 or 2mm",
             options.geometry_error->value);
}

SimplifyResult simplify(const DenseMesh& dense, const PointCloud& cloud,
                        const SimplifyOptions& options, const Context& context) {
    validate(dense, cloud, options);
    report_progress(context, "simplify", 0.0);
    SimplifyResult result;
    SimplifyReport& report = result.report;
    report.num_triangles_before = static_cast<Index>(dense.mesh.triangles.size());

    const WorkingFrame frame(dense.mesh);
    Surface surface(frame.inwards(dense.mesh.positions), dense.mesh.triangles, context);
    Attribution attribution =
        attribute_points(surface, frame.inwards(cloud.positions), dense.vertex_points, context);
    report.bound = find_bound(options, cloud.positions, attribution.distances, frame.unit);
    attribution.link(surface.triangles.size(), report.bound / frame.unit);

    std::vector<Index> owners;
    if (options.keep_mesh) {
        keep(dense, attribution, result, owners);
    } else {
        const double diagonal =
            frame.unit *
            diagonal_of_kept(attribution.points, attribution.distances, report.bound / frame.unit);
        const double margin = std::min(kFloatMargin * diagonal, 0.01 * report.bound);
        FitMesh light = make_light(surface, attribution, options,
                                   (report.bound - margin) / frame.unit, report, context);
        for (Vec3d p : light.positions) result.mesh.positions.push_back(frame.outwards(p));
        result.mesh.triangles = std::move(light.triangles);
        owners = std::move(light.owners);
    }
    measure_points(cloud, attribution, std::move(owners), result, context);
    report_progress(context, "simplify", kMeasuredShare);
    report.mesh_to_surface = mesh_to_surface(result.mesh, dense.mesh, context);
    report.num_triangles = static_cast<Index>(result.mesh.triangles.size());
    report.num_vertices = static_cast<Index>(result.mesh.positions.size());
    report.num_off_surface = static_cast<std::uint64_t>(
        std::count(result.point_triangles.begin(), result.point_triangles.end(), kInvalidIndex));
    report.bound_met = report.bound_met && report.points_to_mesh.max <= report.bound;
    report_progress(context, "simplify", 1.0);
    return result;
}

}  // namespace pointbake
