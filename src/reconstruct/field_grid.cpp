#include "reconstruct/field_grid.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"

namespace pointbake {
namespace {

constexpr std::size_t kGrain = 4096;

// Longest edges of the tetrahedra at the surface, in spacings: shorter ones are not split, longer
// ones always.
constexpr double kFinest = 1.5, kCoarsest = 4.0;
// By how much the field may depart from a linear one along an edge, in spacings. Without noise, and
// per noise.
constexpr double kTolerance = 0.02, kTolerancePerNoise = 0.05;
// Below this density the surface is extrapolated: not worth a fine grid.
constexpr float kLeastDensity = 0.1F;

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
    return SimplexGrid(corner, size, num_cubes);
}

/// How far the field departs from a linear one along an edge: half the second difference of its
/// values there, or what the turn of the normals amounts to.
double bending(const FieldSample& middle, const FieldSample& a, const FieldSample& b,
               double edge_length) {
    const double surplus = std::abs(middle.value - 0.5F * (a.value + b.value));
    const float turn = std::max(length(middle.normal - a.normal), length(middle.normal - b.normal));
    // A circle's arc: the normals turn by edge / (2 R) on half the edge, the rise is edge^2 / (8
    // R).
    return std::max(surplus, 0.25 * edge_length * turn);
}

class Refiner {
 public:
    Refiner(const SignedDistance& field, const Context& context)
        : field_(field),
          context_(context),
          tolerance_(kTolerance + kTolerancePerNoise * field.noise()),
          result_{make_grid(field), {}} {}

    /// Rounds of: sample new vertices, find candidates around them, split those that need it.
    FieldGrid run() {
        SimplexGrid& grid = result_.grid;
        for (std::size_t done = 0; done < grid.vertices().size();) {
            const std::size_t end = grid.vertices().size();
            sample_new_nodes();
            const Index first = grid.num_nodes();
            for (const Point& p : find_candidates(done, end)) grid.add(p);
            sample_new_nodes();
            const std::vector<std::uint8_t> wants = find_wants(first);
            for (std::size_t i = 0; i < wants.size(); ++i)
                if (wants[i]) grid.split(first + static_cast<Index>(i));
            done = end;
        }
        return std::move(result_);
    }

 private:
    using Point = SimplexGrid::Point;

    void sample_new_nodes() {
        const std::size_t first = result_.samples.size();
        result_.samples.resize(result_.grid.num_nodes());
        const std::span fresh = std::span(result_.samples).subspan(first);
        parallel_for(context_, fresh.size(), kGrain, [&](std::size_t begin, std::size_t end) {
            std::vector<Vec3d> places;
            for (std::size_t i = begin; i < end; ++i)
                places.push_back(result_.grid.place(static_cast<Index>(first + i)));
            std::ranges::copy(field_.at(places),
                              fresh.begin() + static_cast<std::ptrdiff_t>(begin));
        });
    }

    /// Around the vertices from `begin` to `end`, in the order in which they came.
    std::vector<Point> find_candidates(std::size_t begin, std::size_t end) const {
        const SimplexGrid& grid = result_.grid;
        const auto in_range = [&](std::size_t first, std::size_t last) {
            std::vector<Point> found;
            for (std::size_t i = begin + first; i < begin + last; ++i)
                grid.for_each_child(grid.vertices()[i], [&](const Point& p) {
                    if (grid.find(p) == kInvalidIndex && may_want_split(p)) found.push_back(p);
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

    /// False where the ends of the edge tell already that it is short enough, or that the surface
    /// passes elsewhere: most samples are saved so.
    bool may_want_split(const Point& p) const {
        const auto [a, b] = result_.grid.edge(p);
        const FieldSample &at_a = result_.samples[a], &at_b = result_.samples[b];
        if (!at_a.is_known || !at_b.is_known) return true;
        const double edge_length = result_.grid.edge_length(p);
        const double spacing = std::min(at_a.spacing, at_b.spacing);
        if (edge_length <= kFinest * spacing) return false;
        const double height = std::max(std::abs(at_a.value), std::abs(at_b.value));
        return edge_length > kCoarsest * spacing ||
               height - 0.5 * edge_length <= result_.grid.reach(p);
    }

    std::vector<std::uint8_t> find_wants(Index first) const {
        std::vector<std::uint8_t> wants(result_.grid.num_nodes() - first);
        parallel_for(context_, wants.size(), kGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                wants[i] = wants_split(first + static_cast<Index>(i));
        });
        return wants;
    }

    bool wants_split(Index node) const {
        const SimplexGrid& grid = result_.grid;
        const FieldSample& s = result_.samples[node];
        const Point& p = grid.point(node);
        const double edge_length = grid.edge_length(p), reach = grid.reach(p);
        if (!s.is_known) return field_.has_point_within(grid.place(p), reach);
        if (edge_length <= kFinest * s.spacing) return false;
        if (edge_length > kCoarsest * s.spacing)
            return field_.has_point_within(grid.place(p), reach + s.spacing);
        if (std::abs(s.value) > reach || s.density < kLeastDensity) return false;
        if (s.is_bent) return true;
        const auto [a, b] = grid.edge(p);
        const FieldSample &at_a = result_.samples[a], &at_b = result_.samples[b];
        if (!at_a.is_known || !at_b.is_known) return true;
        return bending(s, at_a, at_b, edge_length) > tolerance_ * s.spacing;
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
