// Where the signed distance is sampled: fine near the surface where that is curved, else coarse.
#pragma once

#include <vector>

#include "reconstruct/signed_distance.h"
#include "reconstruct/simplex_grid.h"

namespace pointbake {

struct FieldGrid {
    SimplexGrid grid;
    std::vector<FieldSample> samples;  ///< per node
};

/// Anchored at the coordinates' origin, around all points with a margin. There must be points.
FieldGrid sample_adaptively(const SignedDistance& field, const Context& context);

}  // namespace pointbake
