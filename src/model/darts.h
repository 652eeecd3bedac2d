// Evenly spread points on a mesh.
#pragma once

#include <vector>

#include "pointbake/context.h"
#include "pointbake/types.h"

namespace pointbake {

struct SurfacePoint {
    Vec3d position;
    Vec3f normal;  ///< of the triangle it lies on
};

/// Exactly `count` points whose number per area follows `density` (positive, smooth, any scale; its
/// range should stay below 16:1). No two points of the same sheet lie nearer than about 0.77 of
/// 1 / sqrt(points per area); gaps stay below about twice that. Deterministic for any number of
/// threads.
std::vector<SurfacePoint> spread_points(const Mesh& mesh, double (*density)(Vec3d),
                                        std::uint64_t count, const Context& context = {});

}  // namespace pointbake
