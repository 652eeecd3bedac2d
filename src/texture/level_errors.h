// The error of every patch at every size it may take: what sizes are chosen from.
#pragma once

#include <vector>

#include "pointbake/texture.h"
#include "texture/triangle_gauge.h"

namespace pointbake {

/// Texels per unit of a patch at a level: 0 = the one-texel patch, 1 = a base of one texel, then
/// sqrt(2) more each.
double level_density(const TriangleFrame& frame, int level);

enum class CapReason : std::uint8_t { kNone, kSpacing, kCount, kSize };
using CapCount = Index CappedCounts::*;

/// Per triangle the levels 0 .. n-1 that it may take, coarse to fine.
class LevelErrors {
 public:
    struct Level {
        float error;          ///< RMS against the splatted function, 8-bit steps; finer than
                              ///< the bound asks for: that of the first level within it
        std::int32_t needed;  ///< texels of the need set
    };
    struct Patch {
        Index begin = 0;  ///< into levels
        std::uint8_t count = 0;
        CapReason cap =
            CapReason::kNone;  ///< what kept it from more levels; kNone = nothing left to gain
        double area = 0.0;     ///< cloud units^2: weight of its error
    };

    std::vector<Patch> patches;
    std::vector<float> widen;  ///< per triangle, as Footprints has it
    std::vector<Level> levels;

    float error(std::size_t t, std::uint8_t level) const {
        return levels[patches[t].begin + level].error;
    }
    std::int32_t needed(std::size_t t, std::uint8_t level) const {
        return levels[patches[t].begin + level].needed;
    }
    /// The first level within the bound, else the one of least error.
    std::uint8_t first_within(std::size_t t, double bound) const;
    /// The level up to `last` where area * error^2 + price * needed is least.
    std::uint8_t cheapest(std::size_t t, std::uint8_t last, double price) const;
    double total_area() const;
    /// What keeps a triangle from more levels.
    CapCount cap(std::size_t t) const;
};

LevelErrors measure_levels(const SplatScene& scene, const PointCloud& cloud, const MapValues& map,
                           const TextureOptions& options, const Context& context);

/// The error figures alone, weighted by the triangles' areas; expects the capped counts.
void summarise_distribution(std::vector<float> errors, std::span<const double> areas,
                            TextureReport& report);

}  // namespace pointbake
