// Dense meshes for the tests of this stage, with the cloud under them.
#pragma once

#include <vector>

#include "core/hash.h"
#include "pointbake/simplify.h"
#include "support/shapes.h"

namespace pointbake::dense_shapes {

struct Input {
    DenseMesh dense;
    PointCloud cloud;
    SimplifyResult simplified(const SimplifyOptions& options, const Context& context = {}) const {
        return simplify(dense, cloud, options, context);
    }
};

/// Every vertex is a point.
inline Input over(Mesh mesh) {
    Input input;
    input.cloud.positions = mesh.positions;
    for (Index v = 0; v < mesh.positions.size(); ++v) input.dense.vertex_points.push_back(v);
    input.dense.mesh = std::move(mesh);
    return input;
}

/// A sphere with bumps that depend on the seed.
inline Mesh bumpy_sphere(Index n, std::uint64_t seed) {
    Mesh mesh = shapes::sphere_mesh(n);
    const double f = 2.0 + 3.0 * random_unit(seed, 1), g = 2.0 + 3.0 * random_unit(seed, 2);
    const double height = 0.03 + 0.12 * random_unit(seed, 3);
    for (Vec3d& p : mesh.positions)
        p = p * (1.0 + height * std::sin(f * p.x + 1.0) * std::cos(g * p.y - p.z));
    return mesh;
}

/// Cube [-1, 1]^3 whose faces are n x n quads; vertices on edges and corners.
inline Mesh fine_cube(Index n) {
    Mesh mesh = shapes::sphere_mesh(n);
    for (Vec3d& p : mesh.positions) {
        const double longest = std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)});
        p = p / longest;
        // Undo the spreading over the sphere, so that the grid is even again.
        for (std::size_t k = 0; k < 3; ++k)
            p[k] = std::abs(p[k]) > 1.0 - 1e-9 ? std::round(p[k])
                                               : std::atan(p[k]) * 4.0 / std::numbers::pi;
    }
    return mesh;
}

/// Only the vertices that a triangle uses.
inline Mesh without_unused(const Mesh& mesh) {
    Mesh out;
    std::vector<Index> new_vertices(mesh.positions.size(), kInvalidIndex);
    for (Triangle t : mesh.triangles) {
        for (Index& v : t) {
            if (new_vertices[v] == kInvalidIndex) {
                new_vertices[v] = static_cast<Index>(out.positions.size());
                out.positions.push_back(mesh.positions[v]);
            }
            v = new_vertices[v];
        }
        out.triangles.push_back(t);
    }
    return out;
}

/// Distance of p to the mesh, by looking at every triangle and not by the code under test.
inline double brute_distance(const Mesh& mesh, Vec3d p) {
    double best = HUGE_VAL;
    for (const Triangle& t : mesh.triangles) {
        const Vec3d a = mesh.positions[t[0]], b = mesh.positions[t[1]], c = mesh.positions[t[2]];
        const Vec3d n = cross(b - a, c - a);
        const Vec3d q = p - n * (dot(p - a, n) / squared_length(n));
        if (dot(cross(b - a, q - a), n) >= 0 && dot(cross(c - b, q - b), n) >= 0 &&
            dot(cross(a - c, q - c), n) >= 0)
            best = std::min(best, length(p - q));
        for (const auto& [s, e] : {std::pair{a, b}, {b, c}, {c, a}}) {
            const double u = std::clamp(dot(p - s, e - s) / squared_length(e - s), 0.0, 1.0);
            best = std::min(best, length(p - (s + (e - s) * u)));
        }
    }
    return best;
}

}  // namespace pointbake::dense_shapes
