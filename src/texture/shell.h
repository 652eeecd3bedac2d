// The shell around a mesh: every point near it is projected along the interpolated vertex normal
// (F(b, t) = sum b_i (v_i + t n_i); its inverse is one cubic), or orthogonally to the triangle.
#pragma once

#include <array>
#include <vector>

#include "pointbake/context.h"
#include "pointbake/texture.h"
#include "pointbake/types.h"

namespace pointbake {

/// Unit vertex normals with n_i . n_f > 0 for all faces f around a vertex wherever that can be:
/// weighted after [Max99], then turned towards the faces they would miss.
std::vector<Vec3f> shell_normals(const Mesh& mesh, const Context& context);

/// A triangle laid out in its own plane, in cloud units: origin at the left end of the longest
/// edge, x along it, the apex at y > 0 for a counter-clockwise triangle seen from outside.
struct TriangleFrame {
    Vec3d origin, ex, ey, ez;
    std::array<Vec2d, 3> corners;
    int left = 0;  ///< corner at the origin; left+1 is the right end, left+2 the apex
    Vec3d place(Vec2d x) const { return origin + ex * x.x + ey * x.y; }
    double base() const { return corners[static_cast<std::size_t>((left + 1) % 3)].x; }
    double height() const { return corners[static_cast<std::size_t>((left + 2) % 3)].y; }
    double area() const { return 0.5 * base() * height(); }
    /// Of a place in the plane; the triangle must have an area.
    std::array<double, 3> barycentric(Vec2d x) const {
        const double whole = cross(corners[1] - corners[0], corners[2] - corners[0]);
        const double b0 = cross(corners[1] - x, corners[2] - x) / whole,
                     b1 = cross(corners[2] - x, corners[0] - x) / whole;
        return {b0, b1, 1.0 - b0 - b1};
    }
};
TriangleFrame triangle_frame(const Mesh& mesh, Index triangle);

/// Where a point lies above one triangle, and how a small step in space moves its foot.
struct ShellPoint {
    Vec3d barycentric;
    double depth = 0.0;  ///< t, along the interpolated (not normalised) normal
    Vec3d direction;     ///< the interpolated normal, unit length
    std::array<Vec3d, 2>
        gradient{};  ///< d(x, y)/d(p): rows of the map from space to the triangle's plane
};

/// Projects p onto the prism of one triangle; barycentrics may be negative. Falls back to the
/// orthogonal projection where the cubic has no root near the triangle.
class Shell {
 public:
    Shell(const Mesh& mesh, Projection projection, const Context& context);

    const TriangleFrame& frame(Index triangle) const { return frames_[triangle]; }
    const std::vector<Vec3f>& normals() const { return normals_; }
    ShellPoint project(Index triangle, Vec3d p) const;
    /// Interpolated vertex normal (not normalised) at a place in the triangle's plane, clamped into
    /// the triangle.
    Vec3d normal_at(Index triangle, Vec2d place) const;

 private:
    ShellPoint project_orthographic(Index triangle, Vec3d p) const;

    const Mesh& mesh_;
    Projection projection_;
    std::vector<Vec3f> normals_;
    std::vector<TriangleFrame> frames_;
};

}  // namespace pointbake
