// Points off the surface: isolated ones, and those scattered in space.
#pragma once

#include <span>

#include "clean/neighborhoods.h"

namespace pointbake {

/// Sets the fate of outliers to kOutlier; returns their number. O(n).
std::uint64_t mark_outliers(const Neighborhoods& near, std::span<DropReason> fates,
                            const Context& context);

}  // namespace pointbake
