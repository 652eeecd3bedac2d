// The implicit method: an approximating surface for noisy, overlapping scans.
#pragma once

#include <memory>
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
/// (field_grid.h). Sampled once, for both kinds of surface.
/// The same for any number of threads and any order of the points. Near linear. Throws
/// Error{kCancelled}, and Error{kLimit} for points much nearer to each other than the grid's finest
/// edges (extents of some 100 000 spacings).
class ImplicitSurface {
 public:
    explicit ImplicitSurface(const ImplicitInput& input, const Context& context = {});
    ~ImplicitSurface();

    /// Positions and triangles only; 2-manifold, counter-clockwise seen from outside; empty where
    /// no point is used. `is_closed`: without borders and of positive volume; where there are no
    /// points a membrane spans the gap. Else the surface ends where the points end, at most three
    /// spacings beyond.
    Mesh mesh(bool is_closed, const Context& context = {}) const;

 private:
    struct Sampled;
    std::unique_ptr<Sampled> sampled_;
};

/// One of the two.
Mesh implicit_surface(const ImplicitInput& input, bool is_closed, const Context& context = {});

}  // namespace pointbake
