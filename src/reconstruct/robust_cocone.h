// Robust Cocone: which points lie on the outer side of a noisy surface.
#pragma once

#include <span>
#include <vector>

#include "reconstruct/tetrahedra.h"

namespace pointbake {

/// The real points at cells outside, ascending. Outside is what far points reach through cells
/// whose circumspheres are large against the local `spacing` (per real point) and intersect deeply.
/// A surface without noise keeps its outer points but those along concave creases; noise keeps its
/// outer envelope; cavities and what lies in them are left out. O(cells). Throws
/// Error{kCancelled}.
std::vector<Index> outer_points(const Tetrahedra& tets, std::span<const float> spacing,
                                const Context& context);

}  // namespace pointbake
