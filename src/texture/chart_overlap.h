// Does a chart cover a place of its plane twice?
#pragma once

#include <optional>
#include <span>
#include <utility>

#include "texture/flatten.h"

namespace pointbake {

/// Two triangles of a chart that cover the same place of its plane, or nearly touch there but lie
/// far apart on the surface. None of the triangles, which are in ascending order and hang together,
/// may be turned over. Exact for overlaps; touching is looked for on a grid. Near linear.
std::optional<std::pair<Index, Index>> find_overlap(const Mesh& mesh,
                                                    std::span<const std::array<Index, 3>> neighbors,
                                                    std::span<const Index> triangles,
                                                    const FlatCorners& corners);

}  // namespace pointbake
