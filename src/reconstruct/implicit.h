// The implicit method: an approximating surface for noisy, overlapping scans.
#pragma once

#include <span>

#include "pointbake/context.h"
#include "pointbake/types.h"

namespace pointbake {

struct ImplicitInput {
    std::span<const Vec3d> points;  ///< distinct, finite
    std::span<const Vec3f>
        normals;  ///< unit, oriented outwards; zero = unknown: the point is not used
    std::span<const float>
        spacing;         ///< local spacing per point: root of the area that it stands for
    double noise = 0.0;  ///< standard deviation along the normal, in local spacings
};

/// The zero set of the points' signed distance (signed_distance.h), contoured on an adaptive grid
/// (field_grid.h). Positions and triangles only; 2-manifold, counter-clockwise seen from outside.
/// `is_closed`: without borders and of positive volume; where there are no points a membrane spans
/// the gap. Else the surface ends where the points end, at most three spacings beyond.
/// The same mesh for any number of threads and any order of the points; empty where no point is
/// used. Near linear. Throws Error{kCancelled}.
Mesh implicit_surface(const ImplicitInput& input, bool is_closed, const Context& context = {});

}  // namespace pointbake
