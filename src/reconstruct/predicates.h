// Signs of determinants of coordinates, exact for any doubles: what a triangulation decides by. A
// bound on the rounding errors settles nearly all of them at once.
#pragma once

#include <algorithm>
#include <cmath>

#include "pointbake/types.h"

namespace pointbake {

namespace exact {

int orientation(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d);
bool is_in_sphere(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d, const Vec3d& p);

}  // namespace exact

/// Whether p is in the circle through a, b and c, in whose plane it lies. As for a sphere, one on
/// the circle is on one side too.
bool is_in_circle(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& p);

bool are_collinear(const Vec3d& a, const Vec3d& b, const Vec3d& c);

/// Largest distances along each axis: determinants are bounded by their products.
struct Reach {
    double x = 0.0, y = 0.0, z = 0.0;

    void extend(const Vec3d& d) {
        x = std::max(x, std::abs(d.x));
        y = std::max(y, std::abs(d.y));
        z = std::max(z, std::abs(d.z));
    }
    double least() const { return std::min(x, std::min(y, z)); }
    double most() const { return std::max(x, std::max(y, z)); }
    double volume() const { return x * y * z; }
};

/// Sign of (b - a) . ((c - a) x (d - a)).
inline int orientation(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
    // 6 products of 3 differences, each with up to 8 roundings: 48 units of 2^-53.
    constexpr double kError = 6e-15;
    constexpr double kLeast = 1e-90, kMost = 1e90;  // no overflow, and no underflow that matters
    const Vec3d p = a - d, q = b - d, r = c - d;
    Reach reach;
    reach.extend(p), reach.extend(q), reach.extend(r);
    const double det = -dot(p, cross(q, r)), bound = kError * reach.volume();
    if (std::abs(det) > bound && reach.least() > kLeast && reach.most() < kMost)
        return det > 0 ? 1 : -1;
    return exact::orientation(a, b, c, d);
}

/// Whether p is in the sphere through the positively oriented a, b, c and d. One on the sphere is
/// on the side on which a perturbation puts it that depends on the coordinates alone.
inline bool is_in_sphere(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d,
                         const Vec3d& p) {
    // 72 products of 3 differences and a square, each with up to 16 roundings: 1152 units of 2^-53.
    constexpr double kError = 1.5e-13;
    constexpr double kLeast = 1e-55, kMost = 1e55;
    const Vec3d s = a - p, t = b - p, u = c - p, v = d - p;
    Reach reach;
    reach.extend(s), reach.extend(t), reach.extend(u), reach.extend(v);
    const double st = s.x * t.y - t.x * s.y, tu = t.x * u.y - u.x * t.y;
    const double uv = u.x * v.y - v.x * u.y, vs = v.x * s.y - s.x * v.y;
    const double su = s.x * u.y - u.x * s.y, tv = t.x * v.y - v.x * t.y;
    const double stu = s.z * tu - t.z * su + u.z * st, tuv = t.z * uv - u.z * tv + v.z * tu;
    const double uvs = u.z * vs + v.z * su + s.z * uv, vst = v.z * st + s.z * tv + t.z * vs;
    const double det = (squared_length(s) * tuv - squared_length(t) * uvs) +
                       (squared_length(u) * vst - squared_length(v) * stu);
    const double most = reach.most(), bound = kError * reach.volume() * most * most;
    if (std::abs(det) > bound && reach.least() > kLeast && most < kMost) return det > 0;
    return exact::is_in_sphere(a, b, c, d, p);
}

}  // namespace pointbake
