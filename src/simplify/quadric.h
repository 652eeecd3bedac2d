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

    /// The x of least value: found from `anchor` by steps that each minimise this + pull *
    /// |x - previous x|^2. Directions much stiffer than `pull` are solved for, directions much
    /// softer keep the anchor's place, so that flat regions are no trouble.
    Vec3d minimum_near(Vec3d anchor, double pull, int num_steps) const {
        // (A + pull I) step = -(A x + b), by the adjugate of a symmetric matrix.
        const double a = xx + pull, d = yy + pull, f = zz + pull;
        const double c00 = d * f - yz * yz, c01 = xz * yz - xy * f, c02 = xy * yz - xz * d;
        const double det = a * c00 + xy * c01 + xz * c02;
        if (!(det > 0.0)) return anchor;
        const double c11 = a * f - xz * xz, c12 = xy * xz - a * yz, c22 = a * d - xy * xy;
        Vec3d x = anchor;
        for (int i = 0; i < num_steps; ++i) {
            const Vec3d r = -(times(x) + b) / det;
            x += Vec3d{c00 * r.x + c01 * r.y + c02 * r.z, c01 * r.x + c11 * r.y + c12 * r.z,
                       c02 * r.x + c12 * r.y + c22 * r.z};
        }
        return x;
    }
};

}  // namespace pointbake
