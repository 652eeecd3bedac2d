#include "reconstruct/tetrahedra.h"

#include <algorithm>
#include <numeric>
#include <tuple>

#include "core/morton.h"
#include "core/parallel.h"
#include "core/parallel_sort.h"
#include "reconstruct/delaunay.h"

namespace pointbake {
namespace {

// Corners of a regular dodecahedron on the unit sphere: 1/sqrt(3), g/sqrt(3), 1/(g sqrt(3)) with
// the golden ratio g, as literals.
constexpr double kA = 0.57735026918962576, kB = 0.93417235896271569, kC = 0.35682208977308994;
constexpr std::array<Vec3d, 20> kFarDirections{
    {{kA, kA, kA},   {kA, kA, -kA},  {kA, -kA, kA},   {kA, -kA, -kA}, {-kA, kA, kA},
     {-kA, kA, -kA}, {-kA, -kA, kA}, {-kA, -kA, -kA}, {0, kC, kB},    {0, kC, -kB},
     {0, -kC, kB},   {0, -kC, -kB},  {kC, kB, 0},     {kC, -kB, 0},   {-kC, kB, 0},
     {-kC, -kB, 0},  {kB, 0, kC},    {kB, 0, -kC},    {-kB, 0, kC},   {-kB, 0, -kC}}};
// Far enough that the sphere looks flat from the points, near enough for good numbers.
constexpr double kFarRadius = 10.0;
constexpr std::size_t kGrain = 1U << 14;
constexpr unsigned kMortonBits = 21;

void build_stars(Tetrahedra& tets) {
    tets.star_begin.assign(tets.points.size() + 1, 0);
    for (const auto& cell : tets.cells)
        for (Index v : cell) ++tets.star_begin[v + 1];
    std::partial_sum(tets.star_begin.begin(), tets.star_begin.end(), tets.star_begin.begin());
    tets.star_items.resize(tets.star_begin.back());
    std::vector<Index> next(tets.star_begin.begin(), tets.star_begin.end() - 1);
    for (Index c = 0; c < tets.cells.size(); ++c)
        for (Index v : tets.cells[c]) tets.star_items[next[v]++] = c;
}

}  // namespace

double circumradius2(const Tetrahedra& tets, HalfFacet facet) {
    const auto [i, j, k] = tets.triangle(facet);
    const Vec3d a = tets.points[j] - tets.points[i], b = tets.points[k] - tets.points[i];
    const double n2 = squared_length(cross(a, b));
    if (n2 <= 0) return HUGE_VAL;
    return squared_length(a) * squared_length(b) * squared_length(b - a) / (4.0 * n2);
}

Turn first_turn(const Tetrahedra& tets, HalfFacet facet, std::size_t edge) {
    const Index cell = facet / 4;
    const std::size_t opposite = facet % 4;
    return {cell, kFacetCorners[opposite][(edge + 2) % 3], tets.cells[cell][opposite]};
}

Turn next_turn(const Tetrahedra& tets, const Turn& turn) {
    const HalfFacet entered = tets.mirror(turn.cell * 4 + static_cast<Index>(turn.exit));
    const Index cell = entered / 4;
    return {cell, tets.slot(cell, turn.third), tets.cells[cell][entered % 4]};
}

std::vector<Index> order_by_place(std::span<const Vec3d> points, const Context& context) {
    struct Keyed {
        std::uint64_t code;
        Index id;
    };
    Box box;
    for (const Vec3d& p : points) box.extend(p);
    const Vec3d extent = box.extent();
    const double longest = std::max({extent.x, extent.y, extent.z});
    constexpr double kTop = (1U << kMortonBits) - 1;
    const double scale = longest > 0 ? kTop / longest : 0.0;
    std::vector<Keyed> keys(points.size());
    parallel_for(context, points.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const Vec3d q = (points[i] - box.low) * scale;
            keys[i] = {morton_code(static_cast<std::uint64_t>(q.x), static_cast<std::uint64_t>(q.y),
                                   static_cast<std::uint64_t>(q.z)),
                       static_cast<Index>(i)};
        }
    });
    parallel_sort(context, keys, [&](const Keyed& a, const Keyed& b) {
        if (a.code != b.code) return a.code < b.code;
        const Vec3d &p = points[a.id], &q = points[b.id];
        return std::tie(p.x, p.y, p.z, a.id) < std::tie(q.x, q.y, q.z, b.id);
    });
    std::vector<Index> order(points.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = keys[i].id;
    return order;
}

Tetrahedra tetrahedralize(std::span<const Vec3d> points, const Context& context) {
    Box box;
    for (const Vec3d& p : points) box.extend(p);
    Tetrahedra tets;
    tets.points.reserve(points.size() + kFarDirections.size());
    tets.point_ids.reserve(points.size());
    for (const Index id : order_by_place(points, context)) {
        if (!tets.points.empty() && tets.points.back() == points[id]) continue;
        tets.points.push_back(points[id]);
        tets.point_ids.push_back(id);
    }
    const double radius = kFarRadius * 0.5 * box.diagonal();
    for (const Vec3d& d : kFarDirections) tets.points.push_back(box.center() + d * radius);
    Delaunay simplices = delaunay(tets.points, context);
    tets.cells = std::move(simplices.cells);
    tets.neighbors = std::move(simplices.neighbors);
    build_stars(tets);
    return tets;
}

}  // namespace pointbake
