// Small pictures painted onto the pot.
#pragma once

#include "model/brush.h"

namespace pointbake {

/// A bee that flies to the right; `at` relative to its middle, `size` about its length.
void paint_bee(Vec2d at, double size, double share, Brush& brush);
/// A flower with eight petals.
void paint_flower(Vec2d at, double size, double share, Brush& brush);

}  // namespace pointbake
