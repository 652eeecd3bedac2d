// Row packing with rows kept open, least waste first.
#pragma once

#include "atlas/layout.h"
#include "pointbake/context.h"

namespace pointbake {

/// Places shapes in rows and in what rows leave over, tallest first; those for which there is no
/// row in the gaps between others. Stops at the first that fits nowhere: false; it and all lower
/// shapes stay kUnplaced. O(n log n) in the number of shapes.
bool pack_rows(const ShapeSet& shapes, Layout& layout, const Context& context);

}  // namespace pointbake
