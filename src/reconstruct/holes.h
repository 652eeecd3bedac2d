// Small holes of an indexed surface.
#pragma once

#include <span>

#include "pointbake/context.h"
#include "reconstruct/facet_surface.h"

namespace pointbake {

/// Fills border loops of few edges across which the points are near, unless the filling would be
/// large beside the piece, as that of a rim is: triangles between the loop's vertices, bent as
/// little as possible, then of the least area. No new vertices; a 2-manifold stays one. `points`
/// and `spacing` per vertex. O(n^3) in the edges of a loop.
void fill_holes_in_place(std::span<const Vec3d> points, std::span<const float> spacing,
                         IndexedSurface& surface, const Context& context);

}  // namespace pointbake
