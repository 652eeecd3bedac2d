// How opaque Gaussian splats make space, on a sparse lattice, and what of it is outside.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/splat.h"
#include "pointbake/context.h"
#include "pointbake/types.h"

namespace pointbake {

/// Immutable. Points of the lattice are told by their coordinates in steps, from 0 on.
class SplatGrid {
 public:
    using Point = std::array<std::int32_t, 3>;
    static constexpr double kThinnest =
        0.6;  ///< standard deviation that splats have here, in steps

    /// The step is doubled while the lattice would have too many points: around extents of some
    /// 2 000 steps a side, or surfaces of some 10 million square steps.
    SplatGrid(std::span<const Splat> splats, double step, const Context& context);

    double step() const { return step_; }
    /// Points along each axis.
    Point size() const;
    Vec3d place(Vec3d point) const { return corner_ + point * step_; }

    /// Above 0 outside: where the opacity is less than 0.4 and space hangs together with that
    /// around all splats, through gaps wider than four steps. Linear in the opacity where that is
    /// more, too. Splats are not thinner here than kThinnest.
    float value(const Point& point) const;
    /// The lower corners of the lattice's cubes whose corners have values of both signs, in an
    /// order of their places.
    std::vector<Point> mixed_cubes(const Context& context) const;
    /// The splats that may reach a line between two places, and more, ascending.
    void find_splats(Vec3d from, Vec3d to, std::vector<Index>& found) const;

 private:
    static constexpr std::int32_t kSide = 8;  ///< points per brick and axis
    static constexpr std::size_t kBrickPoints = 512;
    enum State : std::uint8_t { kFree, kBlocked, kOpaque, kOutside };
    struct Reach;
    struct Frontier;

    Reach reach_of(const Splat& splat) const;
    bool is_inside(const Point& p) const;
    std::size_t cell_of(const Point& p) const;
    static std::size_t slot_of(const Point& p);
    Point point_of(std::size_t brick, std::int32_t slot) const;
    State state(const Point& p) const;
    bool lay_out(std::span<const Splat> splats);
    template <class Visit>
    void for_each_cell(const Splat& splat, Visit&& visit) const;
    bool list_bricks(std::span<const Splat> splats, const Context& context);
    void list_splats(std::span<const Splat> splats, const Context& context);
    void dim(const Splat& splat, const Point& origin,
             std::array<float, kBrickPoints>& passed) const;
    void add_opacities(std::span<const Splat> splats, const Context& context);
    std::vector<Point> opaque_points(const Context& context) const;
    void block_near_opaque(const Context& context);
    void flood(const Context& context);
    void grow_outside(const Context& context);

    double step_;
    Vec3d corner_;
    Point bricks_{};               ///< per axis
    std::vector<Index> brick_of_;  ///< per cell of the bricks' lattice; kInvalidIndex = no splats
    std::vector<std::uint8_t> is_outside_;      ///< the same, of cells without splats
    std::vector<Point> brick_points_;           ///< per brick: its first point
    std::vector<Index> splats_begin_, splats_;  ///< per brick
    std::vector<float> opacities_;              ///< per brick and point
    std::vector<State> states_;
};

}  // namespace pointbake
