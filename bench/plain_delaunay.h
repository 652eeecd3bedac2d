// CGAL's Delaunay triangulation as its manual has it: what the stage's time is measured against.
#pragma once

#include <span>

#include "pointbake/types.h"

namespace pointbake {

/// Sequential, in the spatial order that CGAL sorts the points into. Returns the number of cells.
std::size_t plain_delaunay(std::span<const Vec3d> points);

}  // namespace pointbake
