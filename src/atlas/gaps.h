// The last resort: single shapes into any free spot of the pages.
#pragma once

#include "atlas/layout.h"
#include "pointbake/context.h"

namespace pointbake {

/// Puts every shape that is still kUnplaced where it fits between the placed ones, tallest first.
/// False as soon as one finds no spot, or when the search has cost as much as it may.
bool fill_gaps(const ShapeSet& shapes, Layout& layout, const Context& context);

}  // namespace pointbake
