// What attributes and texture agree on.
#pragma once

namespace pointbake {

/// Standard deviation of a splat over its spacing.
inline constexpr float kSplatSigma = 0.6F;

}  // namespace pointbake
