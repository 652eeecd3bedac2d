// Noise of a cloud: how much there is, and points moved onto the surface that they scatter about.
#pragma once

#include "pointbake/context.h"
#include "pointbake/options.h"
#include "pointbake/types.h"

namespace pointbake {

enum class Denoise { kAuto, kOn, kOff };
template <>
struct EnumWords<Denoise> {
    static constexpr std::string_view words[] = {"auto", "on", "off"};
};

struct DenoiseOptions {
    Denoise denoise = Denoise::kAuto;
    template <class Field>
    static void describe(Field&& field) {
        field(
            "denoise", &DenoiseOptions::denoise,
            "move noisy points onto the surface between them: auto (from a noise of 0.05 spacings "
            "on, in files without faces), on, or off");
    }
};

struct DenoiseReport {
    bool is_measured = false;  ///< not where the points are too few
    double noise = 0.0;        ///< measured: median over the points, in local spacings
    double noise_left = 0.0;   ///< likewise, afterwards
    bool is_done = false;
    bool is_relief = false;  ///< tried, and more than half was left: sharp or thin things, no noise
    double shift_rms = 0.0, shift_max = 0.0;  ///< of the points that were moved, cloud units
};

struct DenoiseResult {
    PointCloud cloud;
    DenoiseReport report;
};

/// Noise across the surface: standard deviation of the points from quadrics through their 12 (much
/// noise: 32) nearest neighbours, the median over some 20 000 points, in units of the local
/// spacing. 0 for fewer than 64 points. Reads 0.10, 0.30, 0.81 for noise of 0.1, 0.3 and 1
/// spacings, below 0.02 for clean models.
double measure_noise(const PointCloud& cloud, const Context& context = {});

/// Moves each point along the normal of a quadric that is fitted to its neighbours, onto it. How
/// many neighbours is chosen for each point: the most for which the quadrics of all smaller
/// neighbourhoods agree within their uncertainty (intersection of confidence intervals
/// [Goldenshluger97]), so that creases, rims and sheets close by stay. What was read stays in
/// `cloud.measured`. With `auto`, a cloud that keeps more than half of its noise is handed back
/// unmoved and counts as clean; with `off` the noise is measured for the report alone: in both
/// cloud.noise is 0. O(n log n). The cloud is taken by value and handed back.
DenoiseResult denoise(PointCloud cloud, const DenoiseOptions& options = {},
                      const Context& context = {});

}  // namespace pointbake
