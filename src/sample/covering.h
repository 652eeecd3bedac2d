// Samples where a ray grid leaves gaps.
#pragma once

#include "sample/ray_grid.h"

namespace pointbake {

/// Adds samples so that no point of the surface is farther than 0.87 spacings from one. Inside a
/// region with one dominant axis the grid does that by itself; gaps are along the lines where the
/// axis changes, at creases, and at borders. A new sample takes half the area of the nearest one.
void cover_gaps_in_place(RayGridSamples& grid, const Mesh& mesh, const Context& context);

}  // namespace pointbake
