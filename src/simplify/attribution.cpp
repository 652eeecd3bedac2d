// The lists of original points per triangle that [Klein96] and others keep while decimating.
#include "simplify/attribution.h"

#include "core/bvh.h"
#include "core/parallel.h"

namespace pointbake {
namespace {

constexpr std::size_t kPointGrain = 2048;

Vec3d area_vector(const Surface& surface, Index t) {
    const auto [a, b, c] = surface.corners_of(t);
    return cross(b - a, c - a) * 0.5;
}

// The point at a vertex takes the vertex' normal and a third of the area around it. The weights of
// [Max99] make the normal independent of how flat parts are cut into triangles.
void describe_by_vertex(const Surface& surface, Index vertex, Index point, Attribution& out) {
    const Vec3d center = surface.positions[vertex];
    Vec3d sum;
    double area = 0.0;
    surface.for_each_corner(vertex, [&](Index c) {
        const Vec3d e = surface.positions[surface.after(c)] - center,
                    f = surface.positions[surface.before(c)] - center;
        const Vec3d n = cross(e, f);
        const double lengths = squared_length(e) * squared_length(f);
        if (lengths > 0.0) sum += n / lengths;
        area += 0.5 * length(n);
    });
    out.normals[point] = vec_cast<float>(normalized(sum));
    out.weights[point] += static_cast<float>(area / 3.0);
}

}  // namespace

void Attribution::link(std::size_t num_triangles, double limit) {
    first_points.assign(num_triangles, kInvalidIndex);
    next_points.assign(points.size(), kInvalidIndex);
    for (Index p = static_cast<Index>(points.size()); p-- > 0;) {
        if (distances[p] > limit) owners[p] = kInvalidIndex;
        if (owners[p] != kInvalidIndex) add(owners[p], p);
    }
}

Attribution attribute_points(const Surface& surface, std::vector<Vec3d> points,
                             std::span<const Index> vertex_points, const Context& context) {
    Attribution out;
    const std::size_t n = points.size();
    out.points = std::move(points);
    out.normals.resize(n);
    out.weights.resize(n, 0.0F);
    out.owners.resize(n, kInvalidIndex);
    out.distances.resize(n, 0.0);
    // A vertex that was split lies several times over one point: the first copy takes it.
    for (Index v = 0; v < vertex_points.size(); ++v) {
        const Index p = vertex_points[v];
        if (p == kInvalidIndex || surface.first_corners[v] == kInvalidIndex) continue;
        if (out.owners[p] == kInvalidIndex) out.owners[p] = surface.first_corners[v] / 3;
        describe_by_vertex(surface, v, p, out);
    }
    std::vector<Index> strays;
    for (Index p = 0; p < n; ++p) {
        if (out.owners[p] == kInvalidIndex) strays.push_back(p);
    }
    if (strays.empty()) return out;
    const TriangleBvh bvh(surface.positions, surface.triangles);
    parallel_for(context, strays.size(), kPointGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const Index p = strays[i];
            const auto near = bvh.closest(out.points[p]);
            out.distances[p] = near ? std::sqrt(near->squared_distance) : HUGE_VAL;
            if (!near) continue;
            out.owners[p] = near->triangle;
            const Vec3d area = area_vector(surface, near->triangle);
            out.normals[p] = vec_cast<float>(normalized(area));
            out.weights[p] = static_cast<float>(length(area) / 3.0);
        }
    });
    return out;
}

}  // namespace pointbake
