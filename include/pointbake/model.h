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
/// lettering at several sizes. p is relative to the model's bounding box: (point - low corner) /
/// longest side, so that the longest axis fills [0, 1] and the others begin at 0; n is the outward
/// unit normal. Letters are projected from the six faces of the box and read rightly from outside.
Rgb16 paint_at(Vec3d p, Vec3d n);

/// The demo model as a point cloud of `points` points whose density varies by 4:1 over the surface:
/// positions, colours and rows, as a scan would have. Evenly spread; the same for any number of
/// threads. Throws Error{kInvalidOption} for 0 or more than 100 million points.
PointCloud demo_cloud(std::uint64_t points, const Context& context = {});

}  // namespace pointbake
