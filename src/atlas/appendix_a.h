// The packer of the paper.
#pragma once

#include "atlas/layout.h"
#include "pointbake/context.h"

namespace pointbake {

/// Places shapes in rows as [Wicke05, Appendix A]. False if the pages have no row left for one; it
/// and those after it stay kUnplaced.
bool pack_appendix_a(const ShapeSet& shapes, Layout& layout, const Context& context);

}  // namespace pointbake
