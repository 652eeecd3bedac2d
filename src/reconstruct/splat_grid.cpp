// Free space is flooded from its border. Gaps between splats are narrower than the ways into what
// the splats enclose: points within two steps of opaque ones are passed over first, and taken back
// where they touch what was reached.
#include "reconstruct/splat_grid.h"

#include <algorithm>
#include <cmath>

#include "core/kernel.h"
#include "core/message.h"
#include "core/parallel.h"

namespace pointbake {
namespace {

constexpr float kCut2 = kSplatCut * kSplatCut;
constexpr float kOpaqueFrom = 0.4F;
constexpr float kEnclosed = -0.05F;  // value of free space that is not outside
constexpr int kClosing = 2;          // steps
// Of the bricks' lattice: cells, and those along an axis.
constexpr double kMostCells = 1 << 24, kMostBricks = 1 << 15;
// Bricks with splats, of 2.6 kB each; and splats in them, where they are not many anyway.
constexpr std::size_t kMostListed = 1 << 19, kMostReached = 1 << 28, kBricksPerSplat = 64;
constexpr double kLeastStep = 1e-12;  // of the largest coordinate
constexpr std::size_t kPerPoll = 4096;

using Point = SplatGrid::Point;

constexpr std::array<Point, 6> kSteps{
    {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}};

Point operator+(const Point& a, const Point& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }

/// Half the box around the ellipsoid at the cut.
Vec3d half_extent(const Splat& splat, float thinnest) {
    Vec3d half;
    for (std::size_t k = 0; k < 3; ++k) {
        float sum = 0.0F;
        for (std::size_t a = 0; a < 3; ++a) {
            const float along = splat.axes[a][k] * std::max(splat.sigmas[a], thinnest);
            sum += along * along;
        }
        half[k] = static_cast<double>(kSplatCut * std::sqrt(sum));
    }
    return half;
}

Box box_of(std::span<const Splat> splats, float thinnest) {
    Box box;
    for (const Splat& s : splats) {
        const Vec3d half = half_extent(s, thinnest);
        box.extend(s.center - half);
        box.extend(s.center + half);
    }
    return box;
}

}  // namespace

/// Points that a splat reaches.
struct SplatGrid::Reach {
    Point first, last;
};

SplatGrid::SplatGrid(std::span<const Splat> splats, double step, const Context& context)
    : step_(step) {
    // Finer than coordinates are means nothing.
    for (const Splat& s : splats)
        for (std::size_t k = 0; k < 3; ++k)
            step_ = std::max(step_, kLeastStep * std::abs(s.center[k]));
    while (!lay_out(splats) || !list_bricks(splats, context)) step_ *= 2.0;
    list_splats(splats, context);
    add_opacities(splats, context);
    block_near_opaque(context);
    flood(context);
    grow_outside(context);
}

bool SplatGrid::lay_out(std::span<const Splat> splats) {
    const Box box = box_of(splats, static_cast<float>(kThinnest * step_));
    const double margin = kSide * step_;
    corner_ = box.low - Vec3d{margin, margin, margin};
    const Vec3d extent = box.extent() + Vec3d{margin, margin, margin} * 2.0;
    double cells = 1.0;
    for (std::size_t k = 0; k < 3; ++k) {
        const double count = std::floor(extent[k] / margin) + 1.0;
        cells *= count;
        if (count > kMostBricks) return false;
        bricks_[k] = static_cast<std::int32_t>(count);
    }
    return cells <= kMostCells;
}

Point SplatGrid::size() const {
    return {bricks_[0] * kSide, bricks_[1] * kSide, bricks_[2] * kSide};
}

SplatGrid::Reach SplatGrid::reach_of(const Splat& splat) const {
    const Vec3d half = half_extent(splat, static_cast<float>(kThinnest * step_));
    Reach reach{};
    for (std::size_t k = 0; k < 3; ++k) {
        const double at = (splat.center[k] - corner_[k]) / step_, by = half[k] / step_;
        reach.first[k] = static_cast<std::int32_t>(std::ceil(at - by));
        reach.last[k] = static_cast<std::int32_t>(std::floor(at + by));
    }
    return reach;
}

bool SplatGrid::is_inside(const Point& p) const {
    for (std::size_t k = 0; k < 3; ++k)
        if (p[k] < 0 || p[k] >= bricks_[k] * kSide) return false;
    return true;
}

std::size_t SplatGrid::cell_of(const Point& p) const {
    const auto at = [&](std::size_t k) { return static_cast<std::size_t>(p[k] / kSide); };
    return (at(2) * static_cast<std::size_t>(bricks_[1]) + at(1)) *
               static_cast<std::size_t>(bricks_[0]) +
           at(0);
}

std::size_t SplatGrid::slot_of(const Point& p) {
    return static_cast<std::size_t>(((p[2] % kSide) * kSide + p[1] % kSide) * kSide + p[0] % kSide);
}

SplatGrid::Point SplatGrid::point_of(std::size_t brick, std::int32_t slot) const {
    return brick_points_[brick] + Point{slot % kSide, slot / kSide % kSide, slot / kSide / kSide};
}

SplatGrid::State SplatGrid::state(const Point& p) const {
    const std::size_t cell = cell_of(p);
    const Index brick = brick_of_[cell];
    if (brick == kInvalidIndex) return is_outside_[cell] ? kOutside : kFree;
    return states_[brick * kBrickPoints + slot_of(p)];
}

// From a step before its reach on: so all cubes with one corner in a brick have their lowest one in
// some.
template <class Visit>
void SplatGrid::for_each_cell(const Splat& splat, Visit&& visit) const {
    const Reach r = reach_of(splat);
    Point first{}, last{}, p{};
    for (std::size_t k = 0; k < 3; ++k) {
        first[k] = std::clamp((r.first[k] - 1) / kSide, 0, bricks_[k] - 1);
        last[k] = std::clamp(r.last[k] / kSide, 0, bricks_[k] - 1);
    }
    for (p[2] = first[2]; p[2] <= last[2]; ++p[2])
        for (p[1] = first[1]; p[1] <= last[1]; ++p[1])
            for (p[0] = first[0]; p[0] <= last[0]; ++p[0])
                visit(cell_of({p[0] * kSide, p[1] * kSide, p[2] * kSide}));
}

// False where they are too many. Counts the splats of each.
bool SplatGrid::list_bricks(std::span<const Splat> splats, const Context& context) {
    std::size_t cells = 1, reached = 0, listed = 0;
    for (const std::int32_t n : bricks_) cells *= static_cast<std::size_t>(n);
    brick_of_.assign(cells, 0);
    const std::size_t most = std::max(kMostReached, kBricksPerSplat * splats.size());
    for (std::size_t i = 0; i < splats.size(); ++i) {
        if (i % kPerPoll == 0) check_cancelled(context);
        for_each_cell(splats[i], [&](std::size_t cell) {
            ++reached;
            listed += brick_of_[cell]++ == 0 ? 1 : 0;
        });
        if (listed > kMostListed || reached > most) return false;
    }
    if (reached >= kInvalidIndex)
        fail(ErrorCode::kLimit, "{} splats are more than a surface is laid around", splats.size());
    return true;
}

// Bricks in the order of their places, the splats of each ascending.
void SplatGrid::list_splats(std::span<const Splat> splats, const Context& context) {
    const auto nx = static_cast<std::size_t>(bricks_[0]), ny = static_cast<std::size_t>(bricks_[1]);
    is_outside_.assign(brick_of_.size(), 0);
    splats_begin_.assign(1, 0);
    for (std::size_t cell = 0; cell < brick_of_.size(); ++cell) {
        if (brick_of_[cell] == 0) {
            brick_of_[cell] = kInvalidIndex;
            continue;
        }
        splats_begin_.push_back(splats_begin_.back() + brick_of_[cell]);
        brick_of_[cell] = static_cast<Index>(brick_points_.size());
        brick_points_.push_back({static_cast<std::int32_t>(cell % nx) * kSide,
                                 static_cast<std::int32_t>(cell / nx % ny) * kSide,
                                 static_cast<std::int32_t>(cell / nx / ny) * kSide});
    }
    splats_.resize(splats_begin_.back());
    std::vector<Index> next(splats_begin_.begin(), splats_begin_.end() - 1);
    for (Index i = 0; i < splats.size(); ++i) {
        if (i % kPerPoll == 0) check_cancelled(context);
        for_each_cell(splats[i], [&](std::size_t cell) { splats_[next[brick_of_[cell]]++] = i; });
    }
}

void SplatGrid::find_splats(Vec3d from, Vec3d to, std::vector<Index>& found) const {
    found.clear();
    const int num_steps = static_cast<int>(std::ceil(length(to - from) / step_));
    Index last = kInvalidIndex;
    for (int i = 0; i <= num_steps; ++i) {
        const Vec3d at = from + (to - from) * (static_cast<double>(i) / std::max(num_steps, 1));
        Point p{};
        for (std::size_t k = 0; k < 3; ++k)
            p[k] = static_cast<std::int32_t>(std::floor((at[k] - corner_[k]) / step_));
        if (!is_inside(p)) continue;
        const Index brick = brick_of_[cell_of(p)];
        if (brick == kInvalidIndex || brick == last) continue;
        last = brick;
        found.insert(found.end(), splats_.begin() + splats_begin_[brick],
                     splats_.begin() + splats_begin_[brick + 1]);
    }
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
}

// Of one brick: takes from the light that passes its points what the splat stops.
void SplatGrid::dim(const Splat& splat, const Point& origin,
                    std::array<float, kBrickPoints>& passed) const {
    const auto thinnest = static_cast<float>(kThinnest * step_);
    std::array<Vec3f, 3> inverse;
    for (std::size_t a = 0; a < 3; ++a)
        inverse[a] = splat.axes[a] / std::max(splat.sigmas[a], thinnest);
    const Reach reach = reach_of(splat);
    Point first{}, last{};
    for (std::size_t k = 0; k < 3; ++k) {
        first[k] = std::max(reach.first[k], origin[k]);
        last[k] = std::min(reach.last[k], origin[k] + kSide - 1);
    }
    Point p{};
    for (p[2] = first[2]; p[2] <= last[2]; ++p[2])
        for (p[1] = first[1]; p[1] <= last[1]; ++p[1])
            for (p[0] = first[0]; p[0] <= last[0]; ++p[0]) {
                const Vec3d at = place({static_cast<double>(p[0]), static_cast<double>(p[1]),
                                        static_cast<double>(p[2])});
                const auto d = vec_cast<float>(at - splat.center);
                float q = 0.0F;
                for (const Vec3f& a : inverse) q += dot(a, d) * dot(a, d);
                if (q < kCut2) passed[slot_of(p)] *= 1.0F - splat.opacity * gaussian(q);
            }
}

void SplatGrid::add_opacities(std::span<const Splat> splats, const Context& context) {
    opacities_.assign(brick_points_.size() * kBrickPoints, 0.0F);
    states_.assign(opacities_.size(), kFree);
    constexpr std::size_t kGrain = 16;
    parallel_for(context, brick_points_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        std::array<float, kBrickPoints> passed{};
        for (std::size_t b = begin; b < end; ++b) {
            passed.fill(1.0F);
            for (Index i = splats_begin_[b]; i < splats_begin_[b + 1]; ++i)
                dim(splats[splats_[i]], brick_points_[b], passed);
            for (std::size_t i = 0; i < kBrickPoints; ++i) {
                opacities_[b * kBrickPoints + i] = 1.0F - passed[i];
                if (1.0F - passed[i] >= kOpaqueFrom) states_[b * kBrickPoints + i] = kOpaque;
            }
        }
    });
}

/// Points to go on from.
struct SplatGrid::Frontier {
    std::vector<Point> points, next;
    void advance() {
        points.swap(next);
        next.clear();
    }
};

std::vector<Point> SplatGrid::opaque_points(const Context& context) const {
    std::vector<Point> found;
    for (std::size_t b = 0; b < brick_points_.size(); ++b) {
        if (b % kPerPoll == 0) check_cancelled(context);
        for (std::int32_t i = 0; i < static_cast<std::int32_t>(kBrickPoints); ++i)
            if (states_[b * kBrickPoints + static_cast<std::size_t>(i)] == kOpaque)
                found.push_back(point_of(b, i));
    }
    return found;
}

void SplatGrid::block_near_opaque(const Context& context) {
    Frontier front{opaque_points(context), {}};
    for (int round = 0; round < kClosing; ++round, front.advance())
        for (const Point& p : front.points)
            for (const Point& step : kSteps) {
                const Point q = p + step;
                if (!is_inside(q)) continue;
                const Index brick = brick_of_[cell_of(q)];
                if (brick == kInvalidIndex) continue;
                State& state = states_[brick * kBrickPoints + slot_of(q)];
                if (state != kFree) continue;
                state = kBlocked;
                front.next.push_back(q);
            }
}

// Cells without splats are taken as a whole. The first one is such, by the margin.
void SplatGrid::flood(const Context& context) {
    std::vector<Point> open{{0, 0, 0}};
    std::size_t num_taken = 0;
    is_outside_[0] = 1;
    const auto reach = [&](const Point& q) {
        if (!is_inside(q)) return;
        const std::size_t cell = cell_of(q);
        const Index brick = brick_of_[cell];
        if (brick == kInvalidIndex) {
            if (is_outside_[cell]) return;
            is_outside_[cell] = 1;
        } else {
            State& state = states_[brick * kBrickPoints + slot_of(q)];
            if (state != kFree) return;
            state = kOutside;
        }
        open.push_back(q);
    };
    while (!open.empty()) {
        const Point p = open.back();
        open.pop_back();
        if (++num_taken % kPerPoll == 0) check_cancelled(context);
        if (brick_of_[cell_of(p)] != kInvalidIndex) {
            for (const Point& step : kSteps) reach(p + step);
            continue;
        }
        Point low{};
        for (std::size_t k = 0; k < 3; ++k) low[k] = p[k] / kSide * kSide;
        for (std::size_t k = 0; k < 3; ++k)
            for (std::int32_t i = 0; i < kSide; ++i)
                for (std::int32_t j = 0; j < kSide; ++j)
                    for (const std::int32_t across : {-1, kSide}) {
                        Point q = low;
                        q[k] += across;
                        q[(k + 1) % 3] += i;
                        q[(k + 2) % 3] += j;
                        reach(q);
                    }
    }
}

void SplatGrid::grow_outside(const Context& context) {
    const auto is_beside_outside = [&](const Point& p) {
        return std::any_of(kSteps.begin(), kSteps.end(), [&](const Point& step) {
            return is_inside(p + step) && state(p + step) == kOutside;
        });
    };
    for (int round = 0; round < kClosing; ++round) {
        std::vector<std::size_t> found;
        for (std::size_t b = 0; b < brick_points_.size(); ++b) {
            if (b % kPerPoll == 0) check_cancelled(context);
            for (std::int32_t i = 0; i < static_cast<std::int32_t>(kBrickPoints); ++i) {
                const std::size_t at = b * kBrickPoints + static_cast<std::size_t>(i);
                if (states_[at] == kBlocked && is_beside_outside(point_of(b, i)))
                    found.push_back(at);
            }
        }
        for (const std::size_t at : found) states_[at] = kOutside;
    }
}

float SplatGrid::value(const Point& p) const {
    constexpr float kLeast = 1e-4F;
    if (!is_inside(p)) return kOpaqueFrom;
    const State here = state(p);
    const Index brick = brick_of_[cell_of(p)];
    const float opacity =
        brick == kInvalidIndex ? 0.0F : opacities_[brick * kBrickPoints + slot_of(p)];
    if (here == kOutside) return std::max(kOpaqueFrom - opacity, kLeast);
    return here == kOpaque ? std::min(kOpaqueFrom - opacity, -kLeast) : kEnclosed;
}

std::vector<Point> SplatGrid::mixed_cubes(const Context& context) const {
    const auto in_range = [&](std::size_t begin, std::size_t end) {
        std::vector<Point> found;
        for (std::size_t b = begin; b < end; ++b)
            for (std::int32_t i = 0; i < static_cast<std::int32_t>(kBrickPoints); ++i) {
                const Point p = point_of(b, i);
                bool has_inside = false, has_outside = false;
                for (std::int32_t corner = 0; corner < 8; ++corner) {
                    const Point q = p + Point{corner & 1, corner >> 1 & 1, corner >> 2};
                    (is_inside(q) && state(q) != kOutside ? has_inside : has_outside) = true;
                }
                if (has_inside && has_outside) found.push_back(p);
            }
        return found;
    };
    const auto append = [](std::vector<Point> a, const std::vector<Point>& b) {
        a.insert(a.end(), b.begin(), b.end());
        return a;
    };
    return parallel_reduce(context, brick_points_.size(), 64, std::vector<Point>{}, in_range,
                           append);
}

}  // namespace pointbake
