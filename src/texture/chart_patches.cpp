#include "texture/chart_patches.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "core/parallel.h"
#include "texture/chart_density.h"
#include "texture/least_box.h"

namespace pointbake {
namespace {

constexpr int kStepsPerOctave = 16;
constexpr int kNumLevels = 256;
constexpr std::size_t kGrain = 16;  // charts per chunk

// 2^(level / 16), by square roots: the same on every machine.
double growth(int level) {
    static const std::array<double, kStepsPerOctave> steps = [] {
        std::array<double, kStepsPerOctave> out;
        const double step = std::sqrt(std::sqrt(std::sqrt(std::sqrt(2.0))));
        double value = 1.0;
        for (double& s : out) s = value, value *= step;
        return out;
    }();
    return std::ldexp(steps[static_cast<std::size_t>(level % kStepsPerOctave)],
                      level / kStepsPerOctave);
}

}  // namespace

ChartPatches::ChartPatches(const Mesh& mesh, const std::vector<std::array<Index, 3>>& neighbors,
                           const Shell& shell, const LevelErrors& triangles, int max_side,
                           double gutter, std::optional<double> bound, const Context& context)
    : mesh_(mesh),
      neighbors_(neighbors),
      shell_(shell),
      triangles_(triangles),
      max_side_(max_side),
      gutter_(gutter),
      charts_(grow_charts(mesh, neighbors, context)) {
    if (bound) {
        std::vector<double> wanted(mesh.triangles.size());
        for (Index t = 0; t < wanted.size(); ++t)
            wanted[t] = level_density(shell.frame(t), triangles.first_within(t, *bound));
        split_by_density_in_place(charts_, wanted, gutter, neighbors, context);
    }
    begin_.assign(charts_.count + 1, 0);
    for (const Index c : charts_.of_triangle) ++begin_[c + 1];
    std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
    members_.resize(charts_.of_triangle.size());
    std::vector<Index> next(begin_.begin(), begin_.end() - 1);
    for (Index t = 0; t < members_.size(); ++t) members_[next[charts_.of_triangle[t]]++] = t;
    turn_to_least_box();
    measure_charts(context);
}

// Rows of texels run downwards: y is turned over, so that charts are not mirrored in the image.
void ChartPatches::turn_to_least_box() {
    extent_.resize(charts_.count);
    for (Index c = 0; c < charts_.count; ++c) {
        std::vector<Vec2d> points;
        for (Index i = begin_[c]; i < begin_[c + 1]; ++i)
            for (const Vec2d x : charts_.corners[members_[i]]) points.push_back(x);
        const TurnedBox turned = least_box(points);
        extent_[c] = turned.high - turned.low;
        for (Index i = begin_[c]; i < begin_[c + 1]; ++i)
            for (Vec2d& x : charts_.corners[members_[i]]) {
                const Vec2d p = turned.place(x);
                x = {p.x - turned.low.x, turned.high.y - p.y};
            }
    }
}

bool ChartPatches::is_border(Index t, std::size_t k) const {
    const Index next = neighbors_[t][k];
    return next == kInvalidIndex || charts_.of_triangle[next] != charts_.of_triangle[t];
}

double ChartPatches::density(int level) const { return coarsest_ * growth(level); }

int ChartPatches::level_of(double density) const {
    constexpr double kRounding = 1e-9;
    int low = 0, high = kNumLevels - 1;
    while (low < high) {
        const int middle = (low + high) / 2;
        if (this->density(middle) >= density * (1.0 - kRounding))
            high = middle;
        else
            low = middle + 1;
    }
    return high;
}

// The error of a triangle by itself between the levels that were measured.
double ChartPatches::triangle_error(Index t, double density) const {
    const TriangleFrame& frame = shell_.frame(t);
    const int last = triangles_.patches[t].count - 1;
    int high = 0;
    while (high < last && level_density(frame, high) < density) ++high;
    const auto finer = static_cast<double>(triangles_.error(t, static_cast<std::uint8_t>(high)));
    const double reached = level_density(frame, high);
    if (high == 0 || reached <= density) return finer;
    const auto coarser =
        static_cast<double>(triangles_.error(t, static_cast<std::uint8_t>(high - 1)));
    const double before = level_density(frame, high - 1);
    return coarser + (finer - coarser) * (density - before) / (reached - before);
}

void ChartPatches::measure_charts(const Context& context) {
    double finest = 0.0, largest = 0.0;
    for (Index t = 0; t < members_.size(); ++t)
        finest = std::max(finest, level_density(shell_.frame(t), triangles_.patches[t].count - 1));
    for (const Vec2d e : extent_) largest = std::max({largest, e.x, e.y});
    coarsest_ = std::max(finest / growth(kNumLevels - 1), largest > 0.0 ? 1.0 / largest : 1.0);
    area_.assign(charts_.count, 0.0);
    border_.assign(charts_.count, 0.0);
    first_.assign(charts_.count, 0);
    last_.assign(charts_.count, 0);
    is_cut_.assign(charts_.count, 0);
    squares_.assign(charts_.count, {});
    parallel_for(context, charts_.count, kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t c = begin; c < end; ++c) sum_errors(static_cast<Index>(c));
    });
}

void ChartPatches::sum_errors(Index c) {
    for (Index i = begin_[c]; i < begin_[c + 1]; ++i) {
        const Index t = members_[i];
        const std::array<Vec2d, 3>& x = charts_.corners[t];
        area_[c] += 0.5 * std::fabs(cross(x[1] - x[0], x[2] - x[0]));
        for (std::size_t k = 0; k < 3; ++k)
            if (is_border(t, k)) border_[c] += length(x[(k + 1) % 3] - x[k]);
        last_[c] = std::max(
            last_[c], level_of(level_density(shell_.frame(t), triangles_.patches[t].count - 1)));
    }
    // Texels larger than the triangles would show what lies far around.
    const double triangles = begin_[c + 1] - begin_[c];
    if (area_[c] > 0.0) first_[c] = level_of(std::sqrt(triangles / (2.0 * area_[c])));
    last_[c] = std::max(first_[c], last_[c]);
    const double side = std::max(extent_[c].x, extent_[c].y);
    const double room = max_side_ - 2.0 * gutter_ - 3.0;
    while (last_[c] > 0 && density(last_[c]) * side > room) --last_[c], is_cut_[c] = 1;
    first_[c] = std::min(first_[c], last_[c]);
    squares_[c].resize(static_cast<std::size_t>(last_[c]) + 1);
    for (int level = first_[c]; level <= last_[c]; ++level) {
        double& sum = squares_[c][static_cast<std::size_t>(level)];
        for (Index i = begin_[c]; i < begin_[c + 1]; ++i) {
            const double e = triangle_error(members_[i], density(level));
            sum += triangles_.patches[members_[i]].area * e * e;
        }
    }
}

int ChartPatches::wanted(Index chart, double bound) const {
    int level = first_[chart];
    for (Index i = begin_[chart]; i < begin_[chart + 1]; ++i) {
        const Index t = members_[i];
        level = std::max(
            level, level_of(level_density(shell_.frame(t), triangles_.first_within(t, bound))));
    }
    return level;
}

std::uint8_t ChartPatches::first_within(Index chart, double bound) const {
    return static_cast<std::uint8_t>(std::min(wanted(chart, bound), last_[chart]));
}

double ChartPatches::needed(Index chart, int level) const {
    return chart_texels(area_[chart], border_[chart], density(level), gutter_);
}

double ChartPatches::gutter(Index chart, int level) const {
    return chart_gutter(area_[chart], border_[chart], density(level), gutter_);
}

std::uint8_t ChartPatches::cheapest(Index chart, std::uint8_t last, double price) const {
    auto best = static_cast<std::uint8_t>(first_[chart]);
    double least = HUGE_VAL;
    for (int level = best; level <= last; ++level) {
        const double cost =
            squares_[chart][static_cast<std::size_t>(level)] + price * needed(chart, level);
        if (cost < least) least = cost, best = static_cast<std::uint8_t>(level);
    }
    return best;
}

std::array<Vec2d, 3> ChartPatches::corners(Index t, int level) const {
    const double margin = std::ceil(gutter_);
    std::array<Vec2d, 3> out;
    for (std::size_t k = 0; k < 3; ++k)
        out[k] = charts_.corners[t][k] * density(level) + Vec2d{margin, margin};
    return out;
}

NeedSet ChartPatches::need(Index chart, int level) const {
    constexpr double kRounding = 1e-6;  // texels: a page's coordinates round otherwise
    const int margin = static_cast<int>(std::ceil(gutter_)) + 1;
    const int width = static_cast<int>(extent_[chart].x * density(level)) + 2 * margin + 2,
              height = static_cast<int>(extent_[chart].y * density(level)) + 2 * margin + 2;
    std::vector<std::uint8_t> needed(static_cast<std::size_t>(width) *
                                     static_cast<std::size_t>(height));
    const auto mark = [&](int x, int y) {
        needed[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
               static_cast<std::size_t>(x)] = 1;
    };
    for (Index i = begin_[chart]; i < begin_[chart + 1]; ++i) {
        const Index t = members_[i];
        const std::array<Vec2d, 3> c = corners(t, level);
        const NeedSet need = need_set(c);
        for (int row = 0; row < need.shape.height(); ++row) {
            const PatchShape::Span span = need.shape.rows[static_cast<std::size_t>(row)];
            for (int x = span.left; x <= span.right; ++x)
                mark(x + need.offset_x, row + need.offset_y);
        }
        for (std::size_t k = 0; k < 3; ++k)
            if (is_border(t, k))
                for_each_texel_near(c[k], c[(k + 1) % 3], gutter(chart, level) + kRounding,
                                    [&](int x, int y, double) { mark(x, y); });
    }
    return need_set(needed, width);
}

}  // namespace pointbake
