// Values on a grid of tetrahedra where they are not given.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "reconstruct/simplex_grid.h"

namespace pointbake {

/// Fills in the values of the vertices where `is_given` is 0 so that their zero set has little
/// area: a membrane that spans what is given. Some vertices must be given. A bounded number of
/// steps in a fixed order. O(vertices not given).
void span_membrane_in_place(const SimplexGrid& grid, std::span<const std::uint8_t> is_given,
                            std::vector<float>& values, const Context& context);

}  // namespace pointbake
