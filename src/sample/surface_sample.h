// A place on a mesh.
#pragma once

#include "pointbake/types.h"

namespace pointbake {

/// The point a + u (b - a) + v (c - a) of a triangle abc, and the area that it stands for.
struct SurfaceSample {
    Index triangle = kInvalidIndex;
    float area = 0.0F;
    double u = 0.0, v = 0.0;
};

struct TriangleFrame {
    Vec3d a, ab, ac;

    TriangleFrame(const Mesh& mesh, Index triangle) {
        const Triangle& t = mesh.triangles[triangle];
        a = mesh.positions[t[0]];
        ab = mesh.positions[t[1]] - a;
        ac = mesh.positions[t[2]] - a;
    }
    Vec3d at(double u, double v) const { return a + ab * u + ac * v; }
    /// Along the face normal; its length is twice the area.
    Vec3d normal() const { return cross(ab, ac); }
};

/// The axis along which a triangle with this normal looks largest; ties go to the first.
inline std::size_t dominant_axis(Vec3d normal) {
    const Vec3d a{std::fabs(normal.x), std::fabs(normal.y), std::fabs(normal.z)};
    return a.x >= a.y && a.x >= a.z ? 0U : (a.y >= a.z ? 1U : 2U);
}

inline Vec3d position(const Mesh& mesh, const SurfaceSample& sample) {
    return TriangleFrame(mesh, sample.triangle).at(sample.u, sample.v);
}

}  // namespace pointbake
