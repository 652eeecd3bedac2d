// How double coordinates become floats: relative to a translation where floats alone lose too much.
#pragma once

#include <span>
#include <vector>

#include "pointbake/types.h"

namespace pointbake {

/// Largest loss by rounding to float, as a fraction of the diagonal, that is written without a
/// translation: the geometry bound allows as much for float output.
inline constexpr double kMaxFloatLoss = 1e-6;

struct Placement32 {
    Vec3d translation;             ///< zero if the coordinates are their own floats
    std::vector<Vec3f> positions;  ///< position - translation, rounded, one per vertex
    int exponent = 0;              ///< on a grid: positions are multiples of 2^exponent
    bool has_translation() const { return !(translation == Vec3d{}); }
};

/// Decides by the vertices that triangles use. The translation is the middle of their box, rounded
/// to a multiple of a power of two about as large as the box. Throws Error{kLimit} if a coordinate
/// does not fit a float.
Placement32 place_as_floats(std::span<const Vec3d> positions, std::span<const Triangle> triangles);

/// The same on a grid of a power of two, as coarse as kMaxFloatLoss allows; positions are at most
/// 2^23 steps from 0. Throws Error{kLimit} for extents beyond 1e30 or below 1e-24.
Placement32 place_on_grid(std::span<const Vec3d> positions, std::span<const Triangle> triangles);

/// Whether every coordinate is a float exactly.
bool are_floats(std::span<const Vec3d> positions);

}  // namespace pointbake
