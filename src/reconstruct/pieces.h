// Pieces of a surface over Delaunay points, and which of them are worth keeping.
#pragma once

#include <span>
#include <vector>

#include "reconstruct/tetrahedra.h"

namespace pointbake {

/// Triangles that hang together: those of piece p are members[begin[p]] .. members[begin[p + 1] -
/// 1].
struct Pieces {
    std::vector<Index> begin{0}, members;
    std::size_t size() const { return begin.size() - 1; }
    std::span<const Index> of(std::size_t p) const {
        return std::span(members).subspan(begin[p], begin[p + 1] - begin[p]);
    }
};

/// In the order of their first triangles. `neighbors[t][k]` is any triangle or kInvalidIndex.
Pieces find_pieces(std::span<const std::array<Index, 3>> neighbors);

/// Per piece whether it stays, from the largest down: neither a leftover (a few triangles, half of
/// their points on larger pieces) nor a flake (small, most points within 1.5 spacings of a larger
/// piece). Triangles over the points of `tets`. The largest stays.
std::vector<std::uint8_t> choose_pieces(const Tetrahedra& tets, std::span<const float> spacing,
                                        std::span<const Triangle> triangles, const Pieces& pieces);

}  // namespace pointbake
