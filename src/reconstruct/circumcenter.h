// Circumcentres of cells: the Voronoi vertices.
#pragma once

#include <cmath>

#include "reconstruct/tetrahedra.h"

namespace pointbake {

/// At the cell's first vertex + num / den, den > 0. Homogeneous, as those of nearly flat cells are
/// huge: tests of angles and sizes need no division.
struct Circumcenter {
    Vec3d num;
    double den;
};

inline Circumcenter circumcenter(const Tetrahedra& tets, Index cell) {
    // Where rounding makes a cell's volume zero or negative: its share of the edges' product.
    constexpr double kFlatCell = 1e-17;
    const auto& v = tets.cells[cell];
    const Vec3d o = tets.points[v[0]];
    const Vec3d a = tets.points[v[1]] - o, b = tets.points[v[2]] - o, c = tets.points[v[3]] - o;
    const Vec3d bc = cross(b, c), ca = cross(c, a), ab = cross(a, b);
    const double aa = squared_length(a), bb = squared_length(b), cc = squared_length(c);
    const double den = 2.0 * dot(a, bc);
    return {bc * aa + ca * bb + ab * cc, den > 0 ? den : kFlatCell * std::sqrt(aa * bb * cc)};
}

/// The direction from p to the circumcentre of that cell, times den.
inline Vec3d direction_to(const Tetrahedra& tets, Index cell, const Circumcenter& center, Vec3d p) {
    return center.num + (tets.points[tets.cells[cell][0]] - p) * center.den;
}

}  // namespace pointbake
