// When a cloud counts as noisy.
#pragma once

namespace pointbake {

/// In local spacings: 0.05 with some room to measure it.
inline constexpr double kLeastNoise = 0.045;

}  // namespace pointbake
