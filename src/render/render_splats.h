// Pictures of Gaussian splats.
#pragma once

#include "pointbake/render.h"

namespace pointbake::render {

/// As render_points has it, for clouds that hold splats.
Image render_splats(const PointCloud& cloud, const View& view, const Context& context);

}  // namespace pointbake::render
