// The vertex element of a PLY file as points.
#pragma once

#include <string>

#include "io/ply_body.h"
#include "io/point_table.h"

namespace pointbake {

/// Reads every scalar property. Throws Error{kInvalidInput, kUnsupported} if there are no
/// coordinates, Error{kLimit} beyond 2^32 - 2 rows.
PointRows read_ply_points(const PlyBody& body, const PlyHeader& header, std::size_t element,
                          const std::string& path, const Context& context);

}  // namespace pointbake
