// Analytic shapes for tests: clouds whose true surface is known, and small meshes. Deterministic;
// noise is Gaussian-like with the given standard deviation, along the normal.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "core/hash.h"
#include "pointbake/types.h"

namespace pointbake::shapes {

/// Roughly standard normal: the sum of 12 uniform numbers.
inline double random_normal(std::uint64_t seed, std::uint64_t index) {
    double sum = -6.0;
    for (std::uint64_t k = 0; k < 12; ++k) sum += random_unit(seed, 12 * index + k);
    return sum;
}

/// Appends a point with its outward normal, moved along it by noise, and its row.
inline void add_point(PointCloud& cloud, Vec3d position, Vec3d normal, double noise = 0.0,
                      std::uint64_t seed = 1) {
    const std::uint64_t row = cloud.positions.size();
    if (noise > 0.0) position += normal * (noise * random_normal(seed, row));
    cloud.positions.push_back(position);
    cloud.normals.push_back(vec_cast<float>(normal));
    cloud.rows.push_back(row);
    cloud.num_rows = row + 1;
}

/// The i-th of n points of a Fibonacci spiral on the unit sphere: nearly uniform.
inline Vec3d fibonacci_direction(std::uint64_t i, std::uint64_t n) {
    const double golden_angle = std::numbers::pi * (3.0 - std::sqrt(5.0));
    const double y = 1.0 - (2.0 * static_cast<double>(i) + 1.0) / static_cast<double>(n);
    const double r = std::sqrt(std::max(0.0, 1.0 - y * y));
    const double phi = golden_angle * static_cast<double>(i);
    return {r * std::cos(phi), y, r * std::sin(phi)};
}

/// Unit sphere around the origin. Exact normals, no radii, no colours.
inline PointCloud sphere_cloud(std::uint64_t n, double noise = 0.0, double radius = 1.0,
                               Vec3d center = {}) {
    PointCloud cloud;
    for (std::uint64_t i = 0; i < n; ++i) {
        const Vec3d d = fibonacci_direction(i, n);
        add_point(cloud, center + d * radius, d, noise);
    }
    return cloud;
}

/// Gives all points, which have normals, circular axes of a standard deviation and an opacity.
inline void make_splats(PointCloud& cloud, float sigma, float opacity) {
    cloud.axes.clear();
    for (const Vec3f& n : cloud.normals) {
        const Vec3f aside = std::abs(n.x) < 0.7F ? Vec3f{1, 0, 0} : Vec3f{0, 1, 0};
        const Vec3f across = cross(n, aside), u = across / length(across);
        cloud.axes.push_back({u * sigma, cross(n, u) * sigma});
    }
    cloud.weights.assign(cloud.size(), opacity);
    cloud.are_splats = true;
}

/// The half of the unit sphere with y >= 0: open, one boundary loop (at y = 0).
inline PointCloud half_sphere_cloud(std::uint64_t n, double noise = 0.0) {
    PointCloud cloud;
    for (std::uint64_t i = 0; i < n; ++i) {
        const Vec3d d = fibonacci_direction(i, 2 * n);
        add_point(cloud, d, d, noise);
    }
    return cloud;
}

/// Torus around the y axis: ring radius `major`, tube radius `minor`; uniform by area (R2 sequence,
/// warped).
inline PointCloud torus_cloud(std::uint64_t n, double major = 1.0, double minor = 0.4,
                              double noise = 0.0) {
    PointCloud cloud;
    for (std::uint64_t i = 0; i < n; ++i) {
        const double s = static_cast<double>(i) + 0.5;
        const double u = s * 0.7548776662466927;
        const double phi = 2.0 * std::numbers::pi * (u - std::floor(u));
        // Area grows with major + minor cos(theta): solve Kepler's equation for theta.
        const double mean = 2.0 * std::numbers::pi * s / static_cast<double>(n);
        double theta = mean;
        for (int k = 0; k < 30; ++k) theta = mean - minor / major * std::sin(theta);
        const Vec3d normal{std::cos(theta) * std::cos(phi), std::sin(theta),
                           std::cos(theta) * std::sin(phi)};
        const Vec3d ring{std::cos(phi), 0.0, std::sin(phi)};
        add_point(cloud, ring * major + normal * minor, normal, noise);
    }
    return cloud;
}

/// Grid of nx x nz points in the plane y = 0, `spacing` apart, normal +y, centred on the origin.
/// `jitter` moves points within the plane by at most that share of the spacing.
inline PointCloud plane_cloud(int nx, int nz, double spacing = 0.1, double jitter = 0.0,
                              double noise = 0.0) {
    PointCloud cloud;
    for (int k = 0; k < nz; ++k)
        for (int i = 0; i < nx; ++i) {
            const std::uint64_t row = cloud.positions.size();
            const double jx = jitter * (2.0 * random_unit(11, row) - 1.0);
            const double jz = jitter * (2.0 * random_unit(12, row) - 1.0);
            add_point(
                cloud,
                {spacing * (i - 0.5 * (nx - 1) + jx), 0.0, spacing * (k - 0.5 * (nz - 1) + jz)},
                {0.0, 1.0, 0.0}, noise);
        }
    return cloud;
}

/// Surface of the cube [-1, 1]^3 with n x n points per face at the cells' centres: none on an edge.
inline PointCloud cube_cloud(int n, double noise = 0.0) {
    PointCloud cloud;
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (const double side : {-1.0, 1.0})
            for (int j = 0; j < n; ++j)
                for (int i = 0; i < n; ++i) {
                    Vec3d p, normal;
                    p[axis] = normal[axis] = side;
                    p[(axis + 1) % 3] = -1.0 + (2 * i + 1.0) / n;
                    p[(axis + 2) % 3] = -1.0 + (2 * j + 1.0) / n;
                    add_point(cloud, p, normal, noise);
                }
    return cloud;
}

/// Triangles of a grid of (nu + 1) x (nv + 1) vertices (numbered u first), or of a grid that closes
/// in u and v. The normal points along (d/du) x (d/dv).
inline std::vector<Triangle> grid_triangles(Index nu, Index nv, bool closed) {
    std::vector<Triangle> triangles;
    const Index stride = closed ? nu : nu + 1;
    const auto at = [&](Index u, Index v) {
        return closed ? (v % nv) * stride + u % nu : v * stride + u;
    };
    for (Index v = 0; v < nv; ++v)
        for (Index u = 0; u < nu; ++u) {
            triangles.push_back({at(u, v), at(u + 1, v), at(u + 1, v + 1)});
            triangles.push_back({at(u, v), at(u + 1, v + 1), at(u, v + 1)});
        }
    return triangles;
}

/// Flat grid in the plane y = 0, [-1, 1]^2, normal +y; 2 nu nv triangles. Open.
inline Mesh plane_mesh(Index nu, Index nv) {
    Mesh mesh;
    for (Index v = 0; v <= nv; ++v)
        for (Index u = 0; u <= nu; ++u)
            mesh.positions.push_back({-1.0 + 2.0 * u / nu, 0.0, 1.0 - 2.0 * v / nv});
    mesh.triangles = grid_triangles(nu, nv, false);
    return mesh;
}

/// Closed torus around the y axis, outward orientation; 2 nu nv triangles.
inline Mesh torus_mesh(Index nu, Index nv, double major = 1.0, double minor = 0.4) {
    Mesh mesh;
    for (Index v = 0; v < nv; ++v)
        for (Index u = 0; u < nu; ++u) {
            const double phi = 2.0 * std::numbers::pi * v / nv;
            const double theta = 2.0 * std::numbers::pi * u / nu;
            const double r = major + minor * std::cos(theta);
            mesh.positions.push_back(
                {r * std::cos(phi), minor * std::sin(theta), r * std::sin(phi)});
        }
    mesh.triangles = grid_triangles(nu, nv, true);
    return mesh;
}

/// Cube [-1, 1]^3: 8 vertices, 12 triangles, outward orientation.
inline Mesh cube_mesh() {
    Mesh mesh;
    for (int i = 0; i < 8; ++i)
        mesh.positions.push_back({i & 1 ? 1.0 : -1.0, i & 2 ? 1.0 : -1.0, i & 4 ? 1.0 : -1.0});
    mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                      {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    return mesh;
}

/// Unit sphere: the cube's faces cut into n x n quads each, pushed out; 12 n^2 triangles, closed,
/// outward orientation.
inline Mesh sphere_mesh(Index n, double radius = 1.0) {
    Mesh mesh;
    const auto corner = [&](Vec3d p) {
        // Spread the grid evenly over the sphere (tan of a quarter turn) and merge along cube
        // edges.
        for (std::size_t k = 0; k < 3; ++k)
            p[k] = std::abs(p[k]) == 1.0 ? p[k] : std::tan(p[k] * std::numbers::pi / 4.0);
        const Vec3d position = normalized(p) * radius;
        for (Index i = 0; i < mesh.positions.size(); ++i)
            if (squared_length(mesh.positions[i] - position) < 1e-18 * radius * radius) return i;
        mesh.positions.push_back(position);
        return static_cast<Index>(mesh.positions.size() - 1);
    };
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (const double side : {-1.0, 1.0}) {
            std::vector<Index> grid;
            for (Index j = 0; j <= n; ++j)
                for (Index i = 0; i <= n; ++i) {
                    Vec3d p;
                    p[axis] = side;
                    p[(axis + 1) % 3] = side * (-1.0 + 2.0 * i / n);
                    p[(axis + 2) % 3] = -1.0 + 2.0 * j / n;
                    grid.push_back(corner(p));
                }
            for (const Triangle& t : grid_triangles(n, n, false))
                mesh.triangles.push_back({grid[t[0]], grid[t[1]], grid[t[2]]});
        }
    return mesh;
}

}  // namespace pointbake::shapes
