// Row packing with rows kept open, least waste first.
#pragma once

#include "atlas/layout.h"
#include "pointbake/context.h"

namespace pointbake {

/// Places shapes in rows and in what rows leave over, tallest first. Those that find no room stay
/// kUnplaced. O(n log n) in the number of shapes.
void pack_rows(const ShapeSet& shapes, Layout& layout, const Context& context);

}  // namespace pointbake
