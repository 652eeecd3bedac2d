// Small pieces that float beside the model.
#pragma once

#include <span>

#include "clean/neighborhoods.h"

namespace pointbake {

struct FloaterCounts {
    std::uint64_t num_points = 0, num_pieces = 0;
};

/// Sets the fate of points of floating pieces to kFloating; points that are not kept already are
/// as good as gone. Near linear.
FloaterCounts mark_floaters(const Neighborhoods& near, std::span<DropReason> fates,
                            const Context& context);

}  // namespace pointbake
