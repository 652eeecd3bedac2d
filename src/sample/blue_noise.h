// Blue noise on a mesh.
#pragma once

#include <vector>

#include "pointbake/context.h"
#include "sample/surface_sample.h"

namespace pointbake {

/// `count` samples, evenly but irregularly spread; each stands for the same area. Deterministic.
std::vector<SurfaceSample> sample_blue_noise(const Mesh& mesh, std::uint64_t count,
                                             const Context& context);

}  // namespace pointbake
