// Distances to straight lines between two places.
#pragma once

#include <algorithm>

#include "pointbake/types.h"

namespace pointbake {

/// Of p to the nearest place between a and b, which may be one place.
inline double squared_distance_to_segment(Vec3d p, Vec3d a, Vec3d b) {
    const Vec3d along = b - a;
    const double length2 = squared_length(along);
    const double t = length2 > 0.0 ? std::clamp(dot(p - a, along) / length2, 0.0, 1.0) : 0.0;
    return squared_length(p - (a + along * t));
}

}  // namespace pointbake
