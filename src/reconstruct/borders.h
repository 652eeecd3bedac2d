// Clean borders of open surfaces.
#pragma once

#include <span>

#include "reconstruct/facet_surface.h"
#include "reconstruct/reach.h"

namespace pointbake {

/// Evens out the borders where a vertex is farther than its spacing from the chord between its two
/// neighbours along the border: notches are filled with the triangle over that chord where it goes
/// on smoothly, holds no other vertex and is near the points; then teeth, that is triangles alone
/// at such a vertex, are taken away, at most six from one place, so that a strip one triangle wide
/// is not eaten up; then notches that teeth stood in the way of are filled. The deepest first. A
/// 2-manifold stays one; no new vertices.
/// `points` and `ids` (in those of `reach`) per vertex. O(b log b) in the borders' edges.
void trim_borders_in_place(std::span<const Vec3d> points, std::span<const Index> ids,
                           const Reach& reach, IndexedSurface& surface, const Context& context);

}  // namespace pointbake
