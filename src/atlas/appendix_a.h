// The packer of the paper.
#pragma once

#include "atlas/layout.h"
#include "pointbake/context.h"

namespace pointbake {

/// Places shapes in rows as [Wicke05, Appendix A]. Those for which the pages have no row left stay
/// kUnplaced.
void pack_appendix_a(const ShapeSet& shapes, Layout& layout, const Context& context);

}  // namespace pointbake
