// Row packing with rows kept open, least waste first.
#pragma once

#include "atlas/layout.h"
#include "pointbake/context.h"

namespace pointbake {

/// What a row packing may trade. Which setting is best depends on the shapes in ways that only
/// trying shows.
struct RowStyle {
    double height_loss = 3.0;   ///< weight of texels above a shape lower than its row
    double lowest_share = 0.6;  ///< shapes lower than this share of the row wait for another row
};

/// Places shapes in rows and in what rows leave over, tallest first. Those that find no room stay
/// kUnplaced. O(n log n) in the number of shapes.
void pack_rows(const ShapeSet& shapes, const RowStyle& style, Layout& layout,
               const Context& context);

}  // namespace pointbake
