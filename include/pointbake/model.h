// The painted model that the program makes itself, for demo and tests, and the usual analytic
// shapes.
#pragma once

#include "pointbake/context.h"
#include "pointbake/types.h"

namespace pointbake {

/// A closed, oriented 2-manifold with a thin part, a saddle, a mushroom, sharp creases and smooth
/// ones, about 2 units large.
Mesh demo_mesh();

/// Paint as a function of the place on the model: flat areas, gradients, fine lines, readable
/// lettering at several sizes. p is relative to the bounding box (each axis in [0, 1], the longest
/// axis filling it), n the outward unit normal.
Rgb16 paint_at(Vec3d p, Vec3d n);

/// The demo model as a point cloud of about `points` points whose density varies by 4:1 over the
/// surface.
PointCloud demo_cloud(std::uint64_t points, const Context& context = {});

}  // namespace pointbake
