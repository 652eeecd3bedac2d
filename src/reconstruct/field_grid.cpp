#include "reconstruct/field_grid.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"

namespace pointbake {
namespace {

constexpr std::size_t kGrain = 512;

// Longest edges of the tetrahedra at the surface, in spacings: shorter ones are not split, longer
// ones always.
constexpr double kFinest = 1.5, kCoarsest = 6.0;
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

/// How far the field departs from a linear one along the node's edge: half the second difference of
/// its values there, or what the turn of the normals amounts to.
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

    /// Rounds of: sample new nodes, split those that need it.
    FieldGrid run() {
        for (Index begin = 0; begin < result_.grid.num_nodes();) {
            const Index end = result_.grid.num_nodes();
            sample(begin, end);
            const std::vector<std::uint8_t> wants = find_wants(begin, end);
            for (Index node = begin; node < end; ++node)
                if (wants[node - begin]) result_.grid.split(node);
            begin = end;
        }
        return std::move(result_);
    }

 private:
    void sample(Index begin, Index end) {
        result_.samples.resize(end);
        parallel_for(context_, end - begin, kGrain, [&](std::size_t first, std::size_t last) {
            for (std::size_t i = begin + first; i < begin + last; ++i)
                result_.samples[i] = field_.at(result_.grid.place(static_cast<Index>(i)));
        });
    }

    std::vector<std::uint8_t> find_wants(Index begin, Index end) const {
        std::vector<std::uint8_t> wants(end - begin);
        parallel_for(context_, end - begin, kGrain, [&](std::size_t first, std::size_t last) {
            for (std::size_t i = first; i < last; ++i)
                wants[i] = wants_split(begin + static_cast<Index>(i));
        });
        return wants;
    }

    bool wants_split(Index node) const {
        const SimplexGrid& grid = result_.grid;
        if (grid.is_vertex(node)) return false;
        const FieldSample& s = result_.samples[node];
        const double edge_length = grid.edge_length(node), reach = grid.reach(node);
        if (!s.is_known) return field_.has_point_within(grid.place(node), reach);
        if (edge_length <= kFinest * s.spacing) return false;
        if (edge_length > kCoarsest * s.spacing)
            return field_.has_point_within(grid.place(node), reach + s.spacing);
        if (std::abs(s.value) > reach || s.density < kLeastDensity) return false;
        if (s.is_bent) return true;
        const auto [a, b] = grid.edge(node);
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
