// A triangle prepared for many distance queries.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "core/bvh.h"
#include "pointbake/vec.h"

namespace pointbake {

/// 4 sqrt(3) A / (sum of squared edge lengths): 1 for an equilateral triangle, 0 for a flat one.
inline double triangle_quality(Vec3d a, Vec3d b, Vec3d c) {
    constexpr double k2Sqrt3 = 3.4641016151377545871;
    const double sum = squared_length(b - a) + squared_length(c - b) + squared_length(a - c);
    return sum > 0.0 ? k2Sqrt3 * length(cross(b - a, c - a)) / sum : 0.0;
}

/// The point of a triangle that is closest to another point.
struct ClosestFoot {
    Vec3d barycentric;
    Vec3d direction;  ///< unit, from the foot to the point; the normal if the foot is inside
    double residual;  ///< distance along `direction`, signed where that is the normal
};

struct FaceFrame {
    std::array<Vec3d, 3> corners;
    Vec3d normal;                ///< unit length; zero if the triangle has no area
    std::array<Vec3d, 3> sides;  ///< in the plane, inwards, of the edges k -> k+1, unit length

    FaceFrame() = default;
    FaceFrame(Vec3d a, Vec3d b, Vec3d c) : corners{a, b, c} {
        normal = normalized(cross(b - a, c - a));
        for (std::size_t k = 0; k < 3; ++k)
            sides[k] = normalized(cross(normal, corners[(k + 1) % 3] - corners[k]));
    }
    bool is_flat() const { return normal == Vec3d{}; }
    double quality() const { return triangle_quality(corners[0], corners[1], corners[2]); }

    /// Squared distance of p to the plane.
    double squared_height(Vec3d p) const {
        const double h = dot(p - corners[0], normal);
        return h * h;
    }
    /// Squared distance of p to the triangle if it is at most `limit`; else some number above it.
    double squared_distance(Vec3d p, double limit) const {
        const Vec3d d = p - corners[0];
        const double h = dot(d, normal), h2 = h * h;
        if (h2 > limit) return h2;
        const double s0 = dot(d, sides[0]), s1 = dot(p - corners[1], sides[1]),
                     s2 = dot(d, sides[2]);
        const double lowest = std::min({s0, s1, s2});
        if (lowest >= 0.0 && !is_flat()) return h2;
        const double bound = h2 + lowest * lowest;
        if (bound > limit) return bound;
        // The closest point lies on an edge that the projection is outside of.
        double best = HUGE_VAL;
        if (s0 <= 0.0) best = std::min(best, edge_distance(p, 0));
        if (s1 <= 0.0) best = std::min(best, edge_distance(p, 1));
        if (s2 <= 0.0) best = std::min(best, edge_distance(p, 2));
        return best;
    }

    ClosestFoot foot(Vec3d p) const {
        const Vec3d d = p - corners[0];
        const double s0 = dot(d, sides[0]), s1 = dot(p - corners[1], sides[1]),
                     s2 = dot(d, sides[2]);
        if (s0 > 0.0 && s1 > 0.0 && s2 > 0.0) {
            // Distances to the edges, as shares of the heights over them.
            const double b2 = s0 / dot(corners[2] - corners[0], sides[0]);
            const double b1 = s2 / dot(corners[1] - corners[0], sides[2]);
            return {{1.0 - b1 - b2, b1, b2}, normal, dot(d, normal)};
        }
        const ClosestPoint c = closest_point_on_triangle(p, corners[0], corners[1], corners[2]);
        const double r = std::sqrt(c.squared_distance);
        return {c.barycentric, r > 0.0 ? (p - c.point) / r : normal, r};
    }

 private:
    double edge_distance(Vec3d p, std::size_t k) const {
        const Vec3d e = corners[(k + 1) % 3] - corners[k], d = p - corners[k];
        const double ee = squared_length(e);
        const double t = ee > 0.0 ? std::clamp(dot(d, e) / ee, 0.0, 1.0) : 0.0;
        return squared_length(d - e * t);
    }
};

}  // namespace pointbake
