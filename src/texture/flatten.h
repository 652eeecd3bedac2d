// Laying a chart out in a plane with little stretch.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "pointbake/types.h"

namespace pointbake {

/// Largest ratio of a length in a chart's plane and on the surface, either way.
inline constexpr double kMaxChartStretch = 1.3;

/// Corners of triangles in a plane, cloud units.
using FlatCorners = std::vector<std::array<Vec2d, 3>>;

/// As rigid as possible [Liu08]: begins with the given corners, which no two triangles may turn
/// differently, and moves the vertices until no triangle is stretched by more than
/// kMaxChartStretch, at the same total area. std::nullopt if that is not reached. Triangles that
/// are stretched most weigh more and more. Solves one sparse system per step.
std::optional<FlatCorners> flatten(const Mesh& mesh, std::span<const Index> triangles,
                                   FlatCorners corners);

}  // namespace pointbake
