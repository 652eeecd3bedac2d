// The rays of a layered depth cube that hit a mesh along each triangle's dominant axis.
#pragma once

#include <vector>

#include "pointbake/context.h"
#include "sample/surface_sample.h"

namespace pointbake {

struct RayGridSamples {
    double spacing = 0.0;  ///< between neighbouring rays
    std::vector<SurfaceSample> samples;
};

/// Samples of about `count` rays; each stands for spacing^2 / |n_k| with n_k the largest component
/// of its triangle's unit normal. Of the spacings that give about the count (for 200 000, within 1
/// %), one whose areas sum to nearly the surface's. A ray through an edge or vertex hits one of its
/// triangles.
RayGridSamples sample_on_ray_grid(const Mesh& mesh, std::uint64_t count, const Context& context);

}  // namespace pointbake
