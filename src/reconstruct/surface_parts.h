// Which parts of a contour stay: those that points support.
#pragma once

#include <span>

#include "pointbake/types.h"

namespace pointbake {

/// `support` per vertex: positive where points are. Cuts a 2-manifold along the support's zero line
/// and drops what lies beyond, and pieces of a few triangles; a 2-manifold with borders. Near
/// linear.
Mesh trim(const Mesh& mesh, std::span<const float> support);

/// Moves vertices without support to the mean of their neighbours, some times over: a membrane
/// takes its last shape so. For a closed 2-manifold.
void smooth_unsupported_in_place(Mesh& mesh, std::span<const float> support);

/// Drops pieces of a closed 2-manifold that have support on less than a tenth of their vertices,
/// but not all of them; turns the rest round if its volume is negative.
Mesh keep_supported_pieces(Mesh mesh, std::span<const float> support);

}  // namespace pointbake
