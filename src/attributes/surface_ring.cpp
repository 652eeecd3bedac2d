#include "attributes/surface_ring.h"

#include "core/message.h"

namespace pointbake {
namespace {

/// True if vertex i lies over point i, for all i.
bool is_identity(std::span<const Index> vertex_points) {
    for (std::size_t i = 0; i < vertex_points.size(); ++i)
        if (vertex_points[i] != i) return false;
    return true;
}

void validate(const DenseMesh& surface, std::size_t num_points) {
    if (surface.vertex_points.size() != surface.mesh.positions.size())
        fail(ErrorCode::kInvalidInput, "the surface has {} vertices, but points for {}",
             surface.mesh.positions.size(), surface.vertex_points.size());
    for (std::size_t v = 0; v < surface.vertex_points.size(); ++v)
        if (surface.vertex_points[v] >= num_points)
            fail(ErrorCode::kInvalidInput, "vertex {} lies over point {}; the cloud has {}", v,
                 surface.vertex_points[v], num_points);
}

}  // namespace

SurfaceRings::SurfaceRings(const DenseMesh& surface, std::size_t num_points)
    : mesh_(surface.mesh), triangles_(surface.mesh.triangles) {
    validate(surface, num_points);
    if (!is_identity(surface.vertex_points)) {
        mapped_ = surface.mesh.triangles;
        for (Triangle& t : mapped_)
            for (Index& corner : t) corner = surface.vertex_points[corner];
        triangles_ = mapped_;
    }
    around_ = vertex_triangles(num_points, triangles_);
}

Vec3d SurfaceRings::outward(Index point) const {
    Vec3d sum;
    for (const Index t : around_.of(point)) {
        const Triangle& corners = mesh_.triangles[t];
        const Vec3d a = mesh_.positions[corners[0]];
        sum += cross(mesh_.positions[corners[1]] - a, mesh_.positions[corners[2]] - a);
    }
    return sum;
}

}  // namespace pointbake
