// Points that cannot all stay, and some of them that can.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "pointbake/context.h"
#include "pointbake/types.h"

namespace pointbake {

/// The other points that cannot stay beside one; mutual.
using RivalsOf = std::function<std::span<const Index>(Index point)>;

/// 1 for points no two of which are rivals, and beside which no other point could stay. Greedy in
/// the order of a hash of the coordinates [Cook86], so that the order of the points does not
/// matter.
std::vector<std::uint8_t> choose_among_rivals(std::span<const Vec3d> points,
                                              const RivalsOf& rivals_of, const Context& context);

}  // namespace pointbake
