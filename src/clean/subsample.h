// Thinning to a least distance.
#pragma once

#include <span>

#include "pointbake/context.h"
#include "pointbake/types.h"

namespace pointbake {

/// Sets fates to kSubsampled so that no two points left are nearer than `spacing`, and every other
/// one is nearer than that to one of them; returns their number. Which ones depends on the
/// coordinates alone. O(n log n) for the order, else O(n).
std::uint64_t mark_subsampled(std::span<const Vec3d> positions, double spacing,
                              std::span<DropReason> fates, const Context& context);

}  // namespace pointbake
