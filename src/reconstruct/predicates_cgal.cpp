// Exact signs by CGAL's kernel: no other file of the program includes CGAL. Cospherical points are
// told apart as [Devillers03] has it: each is lifted a little off the paraboloid, those with larger
// coordinates far more than the others.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <array>
#include <tuple>

#include "reconstruct/predicates.h"

namespace pointbake {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;

Point to_point(const Vec3d& p) { return {p.x, p.y, p.z}; }

template <std::size_t N>
void sort_descending(std::array<const Vec3d*, N>& points) {
    std::sort(points.begin(), points.end(), [](const Vec3d* a, const Vec3d* b) {
        return std::tie(a->x, a->y, a->z) > std::tie(b->x, b->y, b->z);
    });
}

}  // namespace

namespace exact {

int orientation(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
    return CGAL::orientation(to_point(a), to_point(b), to_point(c), to_point(d));
}

bool is_in_sphere(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d, const Vec3d& p) {
    const auto side = Kernel().side_of_oriented_sphere_3_object()(
        to_point(a), to_point(b), to_point(c), to_point(d), to_point(p));
    if (side != CGAL::ON_ORIENTED_BOUNDARY) return side == CGAL::ON_POSITIVE_SIDE;
    std::array<const Vec3d*, 5> by_lift{&a, &b, &c, &d, &p};
    sort_descending(by_lift);
    for (const Vec3d* lifted : by_lift) {
        if (lifted == &p) return false;
        const auto corner = [&](const Vec3d& q) { return to_point(&q == lifted ? p : q); };
        const auto sign = CGAL::orientation(corner(a), corner(b), corner(c), corner(d));
        if (sign != CGAL::COPLANAR) return sign == CGAL::POSITIVE;
    }
    return false;
}

}  // namespace exact

bool is_in_circle(const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& p) {
    const auto side = Kernel().coplanar_side_of_bounded_circle_3_object()(to_point(a), to_point(b),
                                                                          to_point(c), to_point(p));
    if (side != CGAL::ON_BOUNDARY) return side == CGAL::ON_BOUNDED_SIDE;
    std::array<const Vec3d*, 4> by_lift{&a, &b, &c, &p};
    sort_descending(by_lift);
    const Vec3d* lifted = by_lift.front();  // no three on a circle are collinear
    if (lifted == &p) return false;
    const auto corner = [&](const Vec3d& q) { return to_point(&q == lifted ? p : q); };
    return CGAL::coplanar_orientation(corner(a), corner(b), corner(c)) ==
           CGAL::coplanar_orientation(to_point(a), to_point(b), to_point(c));
}

bool are_collinear(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    return CGAL::collinear(to_point(a), to_point(b), to_point(c));
}

}  // namespace pointbake
