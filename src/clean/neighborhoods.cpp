#include "clean/neighborhoods.h"

#include <array>
#include <cmath>

#include "core/parallel.h"

namespace pointbake {
namespace {

constexpr std::size_t kGrain = 512;  // points per chunk: about two milliseconds of queries

void find_of(Neighborhoods& out, std::size_t point) {
    std::array<Neighbor, kNeighbors + 1> buffer;
    double sum = 0.0;
    std::size_t k = 0;
    for (const Neighbor& neighbor : out.tree.nearest(out.positions[point], buffer)) {
        if (neighbor.index == point || k == kNeighbors) continue;
        out.neighbors[point * kNeighbors + k++] = neighbor.index;
        sum += std::sqrt(neighbor.squared_distance);
        if (k == kCloseNeighbors) out.spacing[point] = sum / kCloseNeighbors;
    }
    out.reach[point] = sum / kNeighbors;
}

}  // namespace

Neighborhoods find_neighborhoods(std::span<const Vec3d> positions, const Context& context) {
    const std::size_t n = positions.size();
    Neighborhoods out{.positions = positions,
                      .tree = KdTree(positions),
                      .neighbors = std::vector<Index>(n * kNeighbors),
                      .reach = std::vector<double>(n),
                      .spacing = std::vector<double>(n)};
    parallel_for(context, n, kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) find_of(out, i);
    });
    return out;
}

}  // namespace pointbake
