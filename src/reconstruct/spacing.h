// How far apart the points lie, from the Delaunay triangulation.
#pragma once

#include <vector>

#include "reconstruct/tetrahedra.h"

namespace pointbake {

/// Per real point the distance to its 6th nearest Delaunay neighbour, less where neighbours lie
/// denser. 0 for a point without neighbours. O(cells), on all threads.
std::vector<float> local_spacing(const Tetrahedra& tets, const Context& context);

}  // namespace pointbake
