// The vertex element of a PLY file as points: which property means what.
#pragma once

#include <string>
#include <vector>

#include "io/ply_body.h"
#include "pointbake/types.h"

namespace pointbake {

struct PlyPoints {
    PointCloud rows;  ///< one entry per row, not ordered; `rows` and `num_rows` are not filled
    std::vector<std::string> notes;
};

/// Reads every scalar property. Throws Error{kInvalidInput, kUnsupported} if there are no
/// coordinates, Error{kLimit} beyond 2^32 - 2 rows.
PlyPoints read_ply_points(const PlyBody& body, const PlyHeader& header, std::size_t element,
                          const std::string& path, const Context& context);

}  // namespace pointbake
