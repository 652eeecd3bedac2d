// Charts as patches: their shapes at any density, and how large the errors of their triangles are.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "texture/charts.h"
#include "texture/level_errors.h"

namespace pointbake {

/// Visits the texels around the segment from a to b that lie at most `gutter` from it, with the
/// distance.
template <class Visit>
void for_each_texel_near(Vec2d a, Vec2d b, double gutter, Visit&& visit) {
    const Vec2d d = b - a;
    const double l2 = dot(d, d);
    const int x0 = static_cast<int>(std::ceil(std::min(a.x, b.x) - gutter)),
              x1 = static_cast<int>(std::floor(std::max(a.x, b.x) + gutter));
    const int y0 = static_cast<int>(std::ceil(std::min(a.y, b.y) - gutter)),
              y1 = static_cast<int>(std::floor(std::max(a.y, b.y) + gutter));
    for (int y = y0; y <= y1; ++y)
        for (int x = x0; x <= x1; ++x) {
            const Vec2d p = Vec2d{static_cast<double>(x), static_cast<double>(y)} - a;
            const double s = l2 > 0.0 ? std::clamp(dot(p, d) / l2, 0.0, 1.0) : 0.0;
            const double distance = length(p - d * s);
            if (distance <= gutter) visit(x, y, distance);
        }
}

/// All charts at any of the levels, whose densities grow by 2^(1/16).
class ChartPatches {
 public:
    /// `triangles`: the errors of every triangle on its own; `max_side`: of a patch, in texels;
    /// `bound`: if there is one, charts are cut where it wants another density.
    ChartPatches(const Mesh& mesh, const std::vector<std::array<Index, 3>>& neighbors,
                 const Shell& shell, const LevelErrors& triangles, int max_side, double gutter,
                 std::optional<double> bound, const Context& context);

    std::size_t size() const { return charts_.count; }
    /// Texels beyond a chart's border that it fills: fewer where they would outnumber its own.
    double gutter(Index chart, int level) const;
    const Charts& charts() const { return charts_; }
    /// Texels per unit.
    double density(int level) const;
    /// The first level at which all triangles are within the bound, as far as their caps allow.
    std::uint8_t first_within(Index chart, double bound) const;
    std::uint8_t finest(Index chart) const { return static_cast<std::uint8_t>(last_[chart]); }
    /// The level up to `last` where area * error^2 + price * needed is least.
    std::uint8_t cheapest(Index chart, std::uint8_t last, double price) const;
    /// Texels that a chart needs, nearly.
    double needed(Index chart, int level) const;
    /// The texels of its patch; corners() less the offset are inside them.
    NeedSet need(Index chart, int level) const;
    /// Corners of a triangle among the texels of its chart's patch at a level.
    std::array<Vec2d, 3> corners(Index triangle, int level) const;
    /// Whether pages are too small for what the bound asks for.
    bool is_cut_by_size(Index chart, double bound) const {
        return is_cut_[chart] != 0 && wanted(chart, bound) > last_[chart];
    }
    /// Is edge k of a triangle on the border of its chart?
    bool is_border(Index triangle, std::size_t k) const;

 private:
    void turn_to_least_box();
    void measure_charts(const Context& context);
    void sum_errors(Index chart);
    double triangle_error(Index t, double density) const;
    int level_of(double density) const;
    int wanted(Index chart, double bound) const;  // level, of pages that are large enough

    const Mesh& mesh_;
    const std::vector<std::array<Index, 3>>& neighbors_;
    const Shell& shell_;
    const LevelErrors& triangles_;
    int max_side_;
    double gutter_;
    Charts charts_;
    std::vector<Index> begin_, members_;        // triangles by chart
    std::vector<Vec2d> extent_;                 // of each chart, from (0, 0)
    std::vector<double> area_, border_;         // of each chart, in its plane
    double coarsest_ = 1.0;                     // texels per unit of level 0
    std::vector<int> first_, last_;             // per chart: the levels that it may take
    std::vector<std::uint8_t> is_cut_;          // per chart: would be finer if pages were larger
    std::vector<std::vector<double>> squares_;  // per chart and level: area * error^2
};

}  // namespace pointbake
