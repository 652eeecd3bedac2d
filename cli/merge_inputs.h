// Several clouds as one.
#pragma once

#include <vector>

#include "pointbake/context.h"
#include "pointbake/load.h"

namespace pointbake::cli {

/// The points of all files, as if they stood in one after the other: rows count on from file to
/// file. Attributes that not all files have are left out, with a note; so are faces. One file is
/// handed back as it is.
LoadResult merge_inputs(std::vector<LoadResult> parts, const Context& context);

}  // namespace pointbake::cli
