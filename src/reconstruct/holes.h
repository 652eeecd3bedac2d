// Holes of an indexed surface.
#pragma once

#include <optional>
#include <span>

#include "pointbake/context.h"
#include "reconstruct/facet_surface.h"
#include "reconstruct/reach.h"

namespace pointbake {

/// Which holes are filled.
struct HoleRule {
    /// Those with no two vertices farther apart; not told: gaps across which the points are near.
    std::optional<double> size = {};
    /// Gaps are filled as far as it holds, if there is one.
    const Reach* reach = nullptr;
};

/// Fills border loops unless the filling would be large beside the piece, as that of a rim is:
/// triangles between the loop's vertices, bent as little as possible, then of the least area. No
/// new vertices; a 2-manifold stays one. `points` and `spacing` (for gaps only) per vertex. Gaps
/// have at most 64 edges, holes of a size 8192; what is longer stays open. Returns the number of
/// loops filled. O(n^3) in the edges of a loop up to 128, O(n^2) beyond.
Index fill_holes_in_place(std::span<const Vec3d> points, std::span<const float> spacing,
                          const HoleRule& rule, IndexedSurface& surface, const Context& context);

}  // namespace pointbake
