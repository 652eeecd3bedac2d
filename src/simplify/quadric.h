// Quadric error of planes [Garland97], weighted by area, with the place of least error.
#pragma once

#include <algorithm>
#include <cmath>

#include "pointbake/vec.h"

namespace pointbake {

/// Sum of weight * squared distance to planes: x^T A x + 2 b.x + c.
struct Quadric {
    double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
    Vec3d b;
    double c = 0;

    /// Adds the plane through p with unit normal n.
    void add_plane(Vec3d n, Vec3d p, double weight) {
        const double d = -dot(n, p);
        const Vec3d m = n * weight;
        xx += m.x * n.x, xy += m.x * n.y, xz += m.x * n.z;
        yy += m.y * n.y, yz += m.y * n.z, zz += m.z * n.z;
        b += m * d;
        c += weight * d * d;
    }
    Quadric& operator+=(const Quadric& q) {
        xx += q.xx, xy += q.xy, xz += q.xz, yy += q.yy, yz += q.yz, zz += q.zz;
        b += q.b;
        c += q.c;
        return *this;
    }
    double trace() const { return xx + yy + zz; }
    Vec3d times(Vec3d x) const {
        return {xx * x.x + xy * x.y + xz * x.z, xy * x.x + yy * x.y + yz * x.z,
                xz * x.x + yz * x.y + zz * x.z};
    }
    double operator()(Vec3d x) const {
        return std::max(0.0, dot(x, times(x)) + 2.0 * dot(b, x) + c);
    }

    /// The x that minimises this + pull * |x - anchor|^2. With pull > 0 the system is regular: flat
    /// regions then keep the anchor's tangential place.
    Vec3d minimum_near(Vec3d anchor, double pull) const {
        // (A + pull I) (x - anchor) = -(A anchor + b), by the adjugate of a symmetric matrix.
        const Vec3d r = -(times(anchor) + b);
        const double a = xx + pull, d = yy + pull, f = zz + pull;
        const double c00 = d * f - yz * yz, c01 = xz * yz - xy * f, c02 = xy * yz - xz * d;
        const double det = a * c00 + xy * c01 + xz * c02;
        if (!(det > 0.0)) return anchor;
        const double c11 = a * f - xz * xz, c12 = xy * xz - a * yz, c22 = a * d - xy * xy;
        return anchor + Vec3d{c00 * r.x + c01 * r.y + c02 * r.z, c01 * r.x + c11 * r.y + c12 * r.z,
                              c02 * r.x + c12 * r.y + c22 * r.z} /
                            det;
    }
};

}  // namespace pointbake
