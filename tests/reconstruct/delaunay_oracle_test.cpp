// The cells against those of CGAL's own triangulation, on clouds that are hard for predicates. CGAL
// perturbs cospherical points by the same rule, so there is one right answer.
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <ostream>
#include <string>
#include <utility>

#include "core/hash.h"
#include "reconstruct/delaunay.h"

namespace pointbake {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Vertex = CGAL::Triangulation_vertex_base_with_info_3<Index, Kernel>;
using Oracle = CGAL::Delaunay_triangulation_3<Kernel, CGAL::Triangulation_data_structure_3<Vertex>>;
using Corners = std::array<Index, 4>;

std::vector<Corners> sorted(std::vector<Corners> cells) {
    for (Corners& c : cells) std::sort(c.begin(), c.end());
    std::sort(cells.begin(), cells.end());
    return cells;
}

std::vector<Corners> cells_of_cgal(const std::vector<Vec3d>& points) {
    std::vector<std::pair<Kernel::Point_3, Index>> all;
    for (Index i = 0; i < points.size(); ++i)
        all.emplace_back(Kernel::Point_3(points[i].x, points[i].y, points[i].z), i);
    const Oracle triangulation(all.begin(), all.end());
    std::vector<Corners> cells;
    for (const auto c : triangulation.finite_cell_handles())
        cells.push_back({c->vertex(0)->info(), c->vertex(1)->info(), c->vertex(2)->info(),
                         c->vertex(3)->info()});
    return sorted(std::move(cells));
}

Vec3d random_point(std::uint64_t i) {
    return {random_unit(1, i), random_unit(2, i), random_unit(3, i)};
}

std::vector<Vec3d> make(std::size_t n, const std::function<Vec3d(std::size_t)>& place) {
    std::vector<Vec3d> points;
    for (std::size_t i = 0; i < n; ++i) points.push_back(place(i));
    return points;
}

Vec3d on_grid(std::size_t i, double step) {
    const auto at = [](std::size_t k) { return static_cast<double>(k); };
    return Vec3d{at(i % 10), at(i / 10 % 10), at(i / 100)} * step;
}

// Exactly on one sphere: Pythagorean quadruples with all signs and orders.
std::vector<Vec3d> on_a_sphere() {
    std::vector<Vec3d> points;
    for (int x = -21; x <= 21; ++x)
        for (int y = -21; y <= 21; ++y)
            for (int z = -21; z <= 21; ++z)
                if (x * x + y * y + z * z == 21 * 21)
                    points.push_back({double(x), double(y), double(z)});
    return points;
}

struct HardCloud {
    std::string name;
    std::vector<Vec3d> points;
};
void PrintTo(const HardCloud& cloud, std::ostream* out) { *out << cloud.name; }

class DelaunayOracle : public testing::TestWithParam<HardCloud> {};

TEST_P(DelaunayOracle, FindsTheSameCells) {
    const std::vector<Vec3d>& points = GetParam().points;
    const std::vector<Corners> expected = cells_of_cgal(points);
    EXPECT_FALSE(expected.empty());
    EXPECT_EQ(sorted(delaunay(points).cells), expected);
}

INSTANTIATE_TEST_SUITE_P(
    Clouds, DelaunayOracle,
    testing::Values(
        HardCloud{"random", make(3000, random_point)},
        HardCloud{"grid", make(1000, [](std::size_t i) { return on_grid(i, 1.0); })},
        HardCloud{"grid_of_tenths", make(1000, [](std::size_t i) { return on_grid(i, 0.1); })},
        HardCloud{"sphere", on_a_sphere()},
        HardCloud{"nearly_a_sphere",
                  make(1000, [](std::size_t i) { return normalized(random_point(i)); })},
        HardCloud{"two_planes", make(800,
                                     [](std::size_t i) {
                                         const Vec3d p = random_point(i);
                                         return Vec3d{p.x, p.y, double(i % 2)};
                                     })},
        HardCloud{"skew_lines", make(400,
                                     [](std::size_t i) {
                                         const auto at = double(i / 2);
                                         return i % 2 ? Vec3d{at, 0, 0} : Vec3d{0.5, at, 1};
                                     })},
        HardCloud{"plane_and_one", make(500,
                                        [](std::size_t i) {
                                            const Vec3d p = random_point(i);
                                            return Vec3d{p.x, p.y, i == 77 ? 1.0 : 0.0};
                                        })},
        HardCloud{"flat_to_the_last_bit", make(500,
                                               [](std::size_t i) {
                                                   const Vec3d p = random_point(i);
                                                   return Vec3d{p.x, p.y, p.x + p.y + 1e-16 * p.z};
                                               })},
        HardCloud{"far_away",
                  make(1000, [](std::size_t i) { return random_point(i) + Vec3d{5e6, 4e5, 1e3}; })},
        HardCloud{"tiny", make(1000, [](std::size_t i) { return random_point(i) * 1e-70; })},
        HardCloud{"huge", make(1000, [](std::size_t i) { return random_point(i) * 1e60; })},
        HardCloud{"of_all_sizes", make(1000,
                                       [](std::size_t i) {
                                           return random_point(i) *
                                                  std::ldexp(1.0, int(i % 120) - 60);
                                       })}),
    [](const auto& c) { return c.param.name; });

}  // namespace
}  // namespace pointbake
