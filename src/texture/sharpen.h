// Splatting smooths. Sharpening replaces the points' values c by coefficients g whose splatted
// function passes (nearly) through c: g <- g + (c - R(g)), R = normalised splatting at the points.
#pragma once

#include <vector>

#include "pointbake/context.h"
#include "texture/coding.h"
#include "texture/local_field.h"

namespace pointbake {

struct Sharpened {
    std::vector<Vec3f> values;    ///< per item of the footprints
    std::vector<Vec3f> splatted;  ///< R(values) at each item that is not hidden
    int rounds = 0;
};

/// Sharpens by as many rounds as predict best, from nine points in ten (by row): none for noisy
/// colours. `rows`: input row per item.
Sharpened sharpen(const SplatScene& scene, MapKind kind, std::vector<Vec3f> values,
                  std::span<const std::uint64_t> rows, const Context& context);

}  // namespace pointbake
