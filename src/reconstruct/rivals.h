// Points that cannot all stay, and some of them that can.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "pointbake/context.h"
#include "pointbake/types.h"

namespace pointbake {

/// Per point the others that cannot stay beside it; mutual.
struct Rivals {
    std::vector<std::size_t> begin;  ///< one more than there are points
    std::vector<Index> list;

    std::span<const Index> of(Index point) const {
        return std::span(list).subspan(begin[point], begin[point + 1] - begin[point]);
    }
};

/// Asks `append` for the rivals of every point, on all threads; it appends them to a list.
Rivals gather_rivals(std::size_t num_points,
                     const std::function<void(Index point, std::vector<Index>& list)>& append,
                     const Context& context);

/// 1 for points no two of which are rivals, and beside which no other point could stay. Greedy in
/// the order of a hash of the coordinates [Cook86], so that the order of the points does not
/// matter.
std::vector<std::uint8_t> choose_among_rivals(std::span<const Vec3d> points, const Rivals& rivals,
                                              const Context& context);

}  // namespace pointbake
