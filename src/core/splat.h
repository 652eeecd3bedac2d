// A Gaussian splat: an elliptical point with an opacity.
#pragma once

#include <array>

#include "pointbake/types.h"

namespace pointbake {

/// Beyond so many standard deviations splats are nothing.
inline constexpr float kSplatCut = 3.0F;
/// However many there are, some light passes.
inline constexpr float kMostOpaque = 0.99F;

struct Splat {
    Vec3d center;
    std::array<Vec3f, 3> axes{Vec3f{1, 0, 0}, Vec3f{0, 1, 0}, Vec3f{0, 0, 1}};
    std::array<float, 3> sigmas{1.0F, 1.0F, 1.0F};  ///< standard deviations along the axes
    float opacity = 0.0F;                           ///< at the centre, 0 to kMostOpaque
};

/// Of a cloud of splats. The third axis, which clouds do not keep, is a tenth of the
/// shorter one where the point has a normal, else as long. Without opacity where the axes span no
/// area.
Splat splat_of(const PointCloud& cloud, std::size_t point);

}  // namespace pointbake
