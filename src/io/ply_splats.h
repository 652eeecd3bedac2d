// SuperSplat's compressed PLY: chunks of 256 splats, each value between a chunk's least and most.
#pragma once

#include <string>

#include "io/ply_body.h"
#include "io/point_table.h"

namespace pointbake {

/// Whether the element holds packed splats.
bool has_packed_splats(const PlyElement& element);

/// `body` must know the elements up to this and `chunk`. Throws Error{kInvalidInput, kLimit}.
PointRows read_packed_splats(const PlyBody& body, const PlyHeader& header, std::size_t element,
                             const std::string& path, const Context& context);

}  // namespace pointbake
