// From areas to spacings.
#pragma once

#include <cmath>
#include <span>
#include <vector>

namespace pointbake {

/// Spacing of the square grid whose points stand for this area each.
inline float equivalent_spacing(float area) { return std::sqrt(area); }

/// Equivalent spacing of the median area; 0 if there is none.
double median_spacing(std::vector<float> areas);

}  // namespace pointbake
