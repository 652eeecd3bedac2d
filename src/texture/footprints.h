// Surfel first: each point is projected once, into the triangle whose prism holds it. Its Gaussian
// becomes an ellipse in the triangle's plane.
#pragma once

#include <span>
#include <vector>

#include "core/adjacency.h"
#include "core/kernel.h"
#include "pointbake/simplify.h"
#include "texture/shell.h"

namespace pointbake {

/// A splat in the frame of its owner triangle, in cloud units.
struct Footprint {
    Vec2f center;
    float vxx = 0.0F, vxy = 0.0F, vyy = 0.0F;  ///< covariance: V = J J^T
    float depth = 0.0F;
    Index point = kInvalidIndex;
    bool hidden = false;  ///< seen from behind, or covered by another layer: not splatted
};

/// Footprints by owner triangle, within a triangle by point.
struct Footprints {
    std::vector<Index> begin;
    std::vector<Footprint> items;
    std::vector<float> reach;  ///< per triangle: largest radius of a splat around here
    /// Per triangle, how much wider kernels have to be (1, 2 or 4 times) for some to reach each
    /// place along its border, about a spacing apart, as far as 4 is enough; empty: not known yet.
    std::vector<float> widen;
    std::span<const Footprint> of(Index triangle) const {
        return std::span(items).subspan(begin[triangle], begin[triangle + 1] - begin[triangle]);
    }
};

Footprints project_points(const Mesh& mesh, const PointCloud& cloud, std::span<const Index> owners,
                          const Shell& shell, const std::vector<std::array<Index, 3>>& neighbors,
                          const Kernel& kernel, const Context& context);

}  // namespace pointbake
