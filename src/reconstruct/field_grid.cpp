#include "reconstruct/field_grid.h"

#include <algorithm>
#include <cmath>

#include "core/message.h"
#include "core/parallel.h"

namespace pointbake {
namespace {

constexpr std::size_t kGrain = 4096;

// Longest edges of the tetrahedra at the surface, in spacings: shorter ones are not split, longer
// ones always.
constexpr double kFinest = 1.5, kCoarsest = 4.0;
// Ends farther apart than this do not know what is between them.
constexpr double kFarthest = 8.0;
// The surface is no plane.
constexpr double kSlack = 1.1;
// By how much the field may depart from a linear one along an edge, in spacings. Without noise, and
// per noise.
constexpr double kTolerance = 0.015, kTolerancePerNoise = 0.05;
// Below this density the surface is extrapolated: not worth a fine grid.
constexpr float kLeastDensity = 0.1F;

// The grid's finest edges must come down to the points' spacing, or parts of the surface are lost.
void check_resolution(double cube_size, const SignedDistance& field) {
    const double spacing = double{field.median_spacing()};
    if (cube_size / SimplexGrid::kCubeUnits <= kCoarsest * spacing) return;
    fail(ErrorCode::kLimit,
         "the extent of the points is {:.2g} times their spacing, too much for the grid of the "
         "implicit method: --crop what lies far off, or take another --method",
         length(field.box().extent()) / spacing);
}

SimplexGrid make_grid(const SignedDistance& field) {
    const Vec3d extent = field.box().extent();
    const double longest = std::max({extent.x, extent.y, extent.z});
    const double margin = std::max(0.25 * longest, 8.0 * field.min_spacing());
    // The least power of two that is not below half the box.
    double size = std::ldexp(1.0, std::ilogb(margin));
    while (size < 2.0 * margin) size *= 2.0;
    Vec3d corner;
    std::array<int, 3> num_cubes;
    for (std::size_t k = 0; k < 3; ++k) {
        const double first = std::floor((field.box().low[k] - margin) / size);
        corner[k] = first * size;
        num_cubes[k] = static_cast<int>(std::ceil((field.box().high[k] + margin) / size) - first);
    }
    check_resolution(size, field);
    return SimplexGrid(corner, size, num_cubes);
}

/// How far the field departs from a linear one along an edge from a to b. On a circle of radius R
/// the normals turn by edge / R, and the arc rises by edge^2 / (8 R). Between two sheets that face
/// the same way only the values jump.
double bending(const FieldSample& a, const FieldSample& b, Vec3d edge) {
    const double turn = length(a.normal - b.normal);
    const double rise = 0.5 * dot(vec_cast<double>(a.normal + b.normal), edge);
    return std::max(0.125 * length(edge) * turn, 0.25 * std::abs(b.value - a.value - rise));
}

class Refiner {
 public:
    Refiner(const SignedDistance& field, const Context& context)
        : field_(field),
          context_(context),
          tolerance_(kTolerance + kTolerancePerNoise * field.noise()),
          result_{make_grid(field), {}} {}

    /// Rounds of: sample new nodes, split edges that came with them.
    FieldGrid run() {
        SimplexGrid& grid = result_.grid;
        for (Index done = 0; done < grid.num_nodes();) {
            const Index end = grid.num_nodes();
            sample_new_nodes();
            for (const Point& p : find_wants(done, end)) grid.split(p);
            done = end;
        }
        return std::move(result_);
    }

 private:
    using Point = SimplexGrid::Point;

    void sample_new_nodes() {
        const std::size_t first = result_.samples.size();
        std::vector<Vec3d> places;
        for (std::size_t i = first; i < result_.grid.num_nodes(); ++i)
            places.push_back(result_.grid.place(static_cast<Index>(i)));
        const std::vector<FieldSample> fresh = field_.at(places, context_);
        result_.samples.insert(result_.samples.end(), fresh.begin(), fresh.end());
    }

    /// Edges to split, by their midpoints, of those that came with the nodes from `begin` to `end`;
    /// some more than once.
    std::vector<Point> find_wants(Index begin, Index end) const {
        const auto in_range = [&](std::size_t first, std::size_t last) {
            std::vector<Point> found;
            for (std::size_t i = first; i < last; ++i)
                result_.grid.for_each_child(begin + static_cast<Index>(i), [&](const Point& p) {
                    if (wants_split(p)) found.push_back(p);
                });
            return found;
        };
        const auto append = [](std::vector<Point> a, const std::vector<Point>& b) {
            a.insert(a.end(), b.begin(), b.end());
            return a;
        };
        return parallel_reduce(context_, end - begin, kGrain, std::vector<Point>{}, in_range,
                               append);
    }

    /// The ends of an edge tell, if they are no farther apart than they see: the field is smooth
    /// over a few spacings, and where it is not they are bent.
    bool wants_split(const Point& p) const {
        const SimplexGrid& grid = result_.grid;
        const auto [node_a, node_b] = grid.edge(p);
        const FieldSample &a = result_.samples[node_a], &b = result_.samples[node_b];
        const double edge_length = grid.edge_length(p);
        if (!a.is_known || !b.is_known)
            return field_.has_point_within(grid.place(p), grid.reach(p));
        const double spacing = std::min(a.spacing, b.spacing);
        if (edge_length <= kFinest * spacing) return false;
        const bool is_bent = a.is_bent || b.is_bent, is_coarse = edge_length > kCoarsest * spacing;
        if (is_coarse && (is_bent || edge_length > kFarthest * spacing))
            return field_.has_point_within(grid.place(p), grid.reach(p) + spacing);
        if (std::max(a.density, b.density) < kLeastDensity) return false;
        const double height = 0.5 * std::abs(a.value + b.value);
        if (height > kSlack * grid.reach(p, a.normal + b.normal)) return false;
        return is_coarse || is_bent ||
               bending(a, b, grid.place(node_b) - grid.place(node_a)) > tolerance_ * spacing;
    }

    const SignedDistance& field_;
    const Context& context_;
    double tolerance_;
    FieldGrid result_;
};

}  // namespace

FieldGrid sample_adaptively(const SignedDistance& field, const Context& context) {
    return Refiner(field, context).run();
}

}  // namespace pointbake
