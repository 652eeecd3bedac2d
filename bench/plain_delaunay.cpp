#include "plain_delaunay.h"

#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <vector>

namespace pointbake {

std::size_t plain_delaunay(std::span<const Vec3d> points) {
    using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
    std::vector<Kernel::Point_3> all;
    all.reserve(points.size());
    for (const Vec3d& p : points) all.emplace_back(p.x, p.y, p.z);
    return CGAL::Delaunay_triangulation_3<Kernel>(all.begin(), all.end()).number_of_finite_cells();
}

}  // namespace pointbake
