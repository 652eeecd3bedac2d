// Based on [Lengyel01], one triangle at a time: patches meet at texture borders, so nothing is
// averaged.
#include "write/tangents.h"

#include <cmath>

namespace pointbake {
namespace {

constexpr Vec3f kAnyNormal{0.0F, 0.0F, 1.0F};  // where a vertex has no triangle with an area

Vec3f perpendicular_to(Vec3f n) {
    // The axis that n has least of is the farthest from parallel to it.
    const Vec3f a{std::fabs(n.x), std::fabs(n.y), std::fabs(n.z)};
    const Vec3f axis = a.x <= a.y && a.x <= a.z ? Vec3f{1.0F, 0.0F, 0.0F}
                       : a.y <= a.z             ? Vec3f{0.0F, 1.0F, 0.0F}
                                                : Vec3f{0.0F, 0.0F, 1.0F};
    return normalized(cross(axis, n));
}

/// Unit vector along a; zero if it has no direction. In double, divided by its largest coordinate
/// first: squares of small lengths would vanish.
Vec3f unit_or_zero(Vec3d a) {
    const double largest = std::fmax(std::fabs(a.x), std::fmax(std::fabs(a.y), std::fabs(a.z)));
    if (!is_finite(a) || !(largest > 0.0)) return {};
    return vec_cast<float>(normalized(a / largest));
}

Vec3f unit_or_zero(Vec3f a) { return unit_or_zero(vec_cast<double>(a)); }

}  // namespace

std::vector<Vec3f> unit_normals(const Mesh& mesh) {
    std::vector<Vec3d> sums(mesh.positions.size());
    for (const Triangle& t : mesh.triangles) {
        const Vec3d a = mesh.positions[t[0]];
        const Vec3d n = cross(mesh.positions[t[1]] - a, mesh.positions[t[2]] - a);
        for (const Index v : t) sums[v] += n;
    }
    std::vector<Vec3f> normals;
    normals.reserve(sums.size());
    for (std::size_t v = 0; v < sums.size(); ++v) {
        Vec3f n = mesh.normals.empty() ? Vec3f{} : unit_or_zero(mesh.normals[v]);
        if (n == Vec3f{}) n = unit_or_zero(sums[v]);
        normals.push_back(n == Vec3f{} ? kAnyNormal : n);
    }
    return normals;
}

Tangents triangle_tangents(const TexturedMesh& model) {
    if (!model.corner_tangents.empty()) {
        Tangents given{model.corner_tangents, model.tangent_signs};
        if (given.signs.empty()) given.signs.assign(given.directions.size(), std::int8_t{1});
        return given;
    }
    const Mesh& mesh = model.mesh;
    Tangents tangents;
    tangents.directions.reserve(mesh.triangles.size());
    tangents.signs.reserve(mesh.triangles.size());
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
        const Triangle& t = mesh.triangles[i];
        const auto& uv = mesh.uvs[i];
        const Vec3d e1 = mesh.positions[t[1]] - mesh.positions[t[0]];
        const Vec3d e2 = mesh.positions[t[2]] - mesh.positions[t[0]];
        const Vec2f d1 = uv[1] - uv[0], d2 = uv[2] - uv[0];
        const double det = static_cast<double>(d1.x) * d2.y - static_cast<double>(d1.y) * d2.x;
        const Vec3d along_u = e1 * static_cast<double>(d2.y) - e2 * static_cast<double>(d1.y);
        tangents.directions.push_back(unit_or_zero(det < 0.0 ? -along_u : along_u));
        // With v down, a patch seen from outside without mirroring runs clockwise in (u, v).
        tangents.signs.push_back(det <= 0.0 ? std::int8_t{1} : std::int8_t{-1});
    }
    return tangents;
}

Vec3f unit_tangent(Vec3f tangent, Vec3f normal) {
    const Vec3f unit = unit_or_zero(tangent);
    return unit == Vec3f{} ? perpendicular_to(normal) : unit;
}

}  // namespace pointbake
