// Charts: parts of the mesh that lie nearly in a plane each, so that one patch of texels serves
// many triangles.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "pointbake/context.h"
#include "pointbake/types.h"

namespace pointbake {

/// Every triangle in the plane of its chart. Corners keep their order, so that charts seen from
/// outside are counter-clockwise; triangles of a chart that share an edge share it in the plane.
struct Charts {
    std::vector<Index> of_triangle;
    std::vector<std::array<Vec2d, 3>> corners;  ///< cloud units, each chart around its own origin
    Index count = 0;
};

/// Grows charts over adjacent triangles: each is projected along an axis that no normal leaves by
/// more than kMaxChartStretch allows, and covers no place of its plane twice, nor two nearby places
/// that are far apart on the surface. After [CohenSteiner04b], with as many proxies as that takes,
/// then merged while it holds. Any mesh; near linear time. Triangles without an area join a
/// neighbour.
Charts grow_charts(const Mesh& mesh, std::span<const std::array<Index, 3>> neighbors,
                   const Context& context);

}  // namespace pointbake
