// Charts are cut where the wanted density changes, so that flat paint does not pay for the
// lettering beside it.
#pragma once

#include <array>
#include <span>

#include "pointbake/context.h"
#include "texture/charts.h"

namespace pointbake {

/// Cuts every chart into connected parts, as long as that saves texels: a part has the density of
/// its most demanding triangle (`wanted`, texels per unit) and pays for a gutter of `gutter` texels
/// and for being one more (far away, many small charts look worse than few large ones). Parts keep
/// their places in the plane. Triangles are merged into parts in rounds, in each of them the best
/// pairs first; a round is O(n log n), and there are at most 64.
void split_by_density_in_place(Charts& charts, std::span<const double> wanted, double gutter,
                               std::span<const std::array<Index, 3>> neighbors,
                               const Context& context = {});

/// Texels that a chart needs: its area at a density, and its gutter, which is never more than its
/// own.
double chart_texels(double area, double border, double density, double gutter);
/// Width of that gutter, texels.
double chart_gutter(double area, double border, double density, double gutter);

}  // namespace pointbake
