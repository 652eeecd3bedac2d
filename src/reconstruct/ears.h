// A long border made shorter.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "pointbake/types.h"

namespace pointbake {

/// A border with the hole to its left; normals[i] is that of what lies on the other side of the
/// edge from vertex i to i + 1.
struct Loop {
    std::vector<Index> vertices;
    std::vector<Vec3d> normals;
    double piece_area = 0.0;
};

/// Cuts ears off the loop, those over the shortest chords first, until `num_left` edges are left:
/// triangles that hardly bend and hold no other vertex of the loop. `is_edge` tells whether the
/// surface has an edge between two vertices. False if it cannot be made that short. O(n^2).
bool cut_ears_in_place(std::span<const Vec3d> points, std::size_t num_left,
                       const std::function<bool(Index, Index)>& is_edge, Loop& loop,
                       std::vector<Triangle>& ears);

}  // namespace pointbake
