// Dart throwing [Cook86] with a spacing that follows the density: darts come in random order, and
// one is kept unless a kept one lies too near. Departure: space is cut into blocks that are filled
// one after another in eight phases, blocks of a phase being too far apart to know of each other;
// so the darts need no common order and blocks of a phase run in parallel.
#include "model/darts.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "core/hash.h"
#include "core/message.h"
#include "core/parallel.h"

namespace pointbake {
namespace {

// (Spacing * points per length)^2: random packing of discs ends at 0.70 points per squared spacing;
// with kDarts darts per point 0.61 are reached on flat ground. A little less spacing than that
// brings a few points too many, which are left out again.
constexpr double kPacking = 0.595;
constexpr std::uint64_t kDarts = 8;
// Should a round stay short of points (small clouds on thin parts), the next one aims higher by
// this much.
constexpr double kOvershoot = 1.02;
// Points whose normals turn farther apart than this belong to different sides of a thin part.
constexpr float kOtherSide = -0.3F;
constexpr std::uint64_t kSeed = 20051;

struct Dart {
    SurfacePoint point;
    double spacing = 0.0;
};

// Triangles by block, and their mass (area x density) as a running sum in that order.
struct Blocks {
    std::array<int, 3> size{};
    std::vector<Index> triangles;
    std::vector<double> mass;               // up to and with each triangle
    std::vector<std::size_t> begin;         // per block, into triangles
    std::vector<std::vector<Index>> phase;  // blocks that hold triangles, by parity in x, y, z
    double reach = 0.0;                     // side of a block

    double mass_before(std::size_t triangle) const {
        return triangle == 0 ? 0.0 : mass[triangle - 1];
    }
    std::array<int, 3> place(Index block) const {
        const int b = static_cast<int>(block);
        return {b % size[0], b / size[0] % size[1], b / (size[0] * size[1])};
    }
    Index at(std::array<int, 3> p) const {
        return static_cast<Index>((p[2] * size[1] + p[1]) * size[0] + p[0]);
    }
};

class Field {
 public:
    Field(const Mesh& mesh, double (*density)(Vec3d)) : mesh_(mesh), density_(density) {
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
            const Vec3d a = corner(t, 0), b = corner(t, 1), c = corner(t, 2);
            for (const Vec3d& p : {a, b, c}) box_.extend(p);
            longest_ = std::max({longest_, length(b - a), length(c - b), length(a - c)});
            const Vec3d center = (a + b + c) / 3.0;
            mass_.push_back(0.5 * length(cross(b - a, c - a)) * density(center));
            total_ += mass_.back();
            lowest_ = std::min(lowest_, density(center));
        }
    }
    double total_mass() const { return total_; }
    double lowest_density() const { return lowest_; }

    Blocks cut_into_blocks(double largest_spacing) const;

    // `spacing` is that of density 1; x in [0, 1) says where among the block's mass.
    Dart dart(const Blocks& blocks, std::size_t first, std::size_t last, std::uint64_t number,
              double spacing) const {
        const double low = blocks.mass_before(first), high = blocks.mass[last - 1];
        const double x = low + random_unit(kSeed, 3 * number) * (high - low);
        const auto from = blocks.mass.begin();
        const auto at = std::upper_bound(from + static_cast<std::ptrdiff_t>(first),
                                         from + static_cast<std::ptrdiff_t>(last) - 1, x);
        const Index t = blocks.triangles[static_cast<std::size_t>(at - from)];
        // Uniform in the triangle [Turk90].
        const double r = std::sqrt(random_unit(kSeed, 3 * number + 1));
        const double s = random_unit(kSeed, 3 * number + 2);
        const Vec3d a = corner(t, 0), b = corner(t, 1), c = corner(t, 2);
        const Vec3d p = a * (1.0 - r) + b * (r * (1.0 - s)) + c * (r * s);
        return {{p, vec_cast<float>(normalized(cross(b - a, c - a)))},
                spacing / std::sqrt(density_(p))};
    }

 private:
    Vec3d corner(std::size_t t, std::size_t k) const {
        return mesh_.positions[mesh_.triangles[t][k]];
    }
    const Mesh& mesh_;
    double (*density_)(Vec3d);
    std::vector<double> mass_;
    Box box_;
    double total_ = 0.0, longest_ = 0.0, lowest_ = HUGE_VAL;
};

Blocks Field::cut_into_blocks(double largest_spacing) const {
    // Triangles belong to the block of their centre and reach out of it by less than their longest
    // edge; blocks of one phase are one block apart.
    constexpr int kMaxBlocks = 40;  // per axis: enough to keep many threads busy
    const Vec3d extent = box_.extent();
    const double longest = std::max({extent.x, extent.y, extent.z});
    Blocks blocks;
    blocks.reach = std::max(2.0 * longest_ + 2.0 * largest_spacing, longest / kMaxBlocks);
    for (std::size_t k = 0; k < 3; ++k)
        blocks.size[k] = static_cast<int>(extent[k] / blocks.reach) + 1;
    const auto count = static_cast<std::size_t>(blocks.size[0]) *
                       static_cast<std::size_t>(blocks.size[1]) *
                       static_cast<std::size_t>(blocks.size[2]);
    std::vector<Index> block_of(mesh_.triangles.size());
    blocks.begin.assign(count + 1, 0);
    for (std::size_t t = 0; t < block_of.size(); ++t) {
        const Vec3d q = (corner(t, 0) + corner(t, 1) + corner(t, 2)) / 3.0 - box_.low;
        std::array<int, 3> p{};
        for (std::size_t k = 0; k < 3; ++k)
            p[k] = std::min(static_cast<int>(q[k] / blocks.reach), blocks.size[k] - 1);
        block_of[t] = blocks.at(p);
        ++blocks.begin[block_of[t] + 1];
    }
    for (std::size_t b = 0; b < count; ++b) blocks.begin[b + 1] += blocks.begin[b];
    std::vector<std::size_t> next(blocks.begin.begin(), blocks.begin.end() - 1);
    blocks.triangles.resize(block_of.size());
    for (Index t = 0; t < block_of.size(); ++t) blocks.triangles[next[block_of[t]]++] = t;
    double sum = 0.0;
    for (const Index t : blocks.triangles) blocks.mass.push_back(sum += mass_[t]);
    blocks.phase.resize(8);
    for (Index b = 0; b < count; ++b) {
        const auto [x, y, z] = blocks.place(b);
        if (blocks.begin[b] < blocks.begin[b + 1])
            blocks.phase[static_cast<std::size_t>(x % 2 + y % 2 * 2 + z % 2 * 4)].push_back(b);
    }
    return blocks;
}

// Darts kept in and around one block, in cells as wide as the largest spacing.
class Board {
 public:
    Board(const Box& box, double cell) : low_(box.low), cell_(cell) {
        std::size_t cells = 1;
        for (std::size_t k = 0; k < 3; ++k) {
            size_[k] = static_cast<int>(box.extent()[k] / cell) + 1;
            cells *= static_cast<std::size_t>(size_[k]);
        }
        head_.assign(cells, kInvalidIndex);
    }
    bool has_room(const Dart& d) const {
        const std::array<int, 3> c = cell_of(d.point.position);
        for (int z = std::max(0, c[2] - 1); z <= std::min(size_[2] - 1, c[2] + 1); ++z)
            for (int y = std::max(0, c[1] - 1); y <= std::min(size_[1] - 1, c[1] + 1); ++y)
                for (int x = std::max(0, c[0] - 1); x <= std::min(size_[0] - 1, c[0] + 1); ++x)
                    for (Index k = head_[at({x, y, z})]; k != kInvalidIndex; k = next_[k])
                        if (is_too_near(d, darts_[k])) return false;
        return true;
    }
    void put(const Dart& d) {
        Index& head = head_[at(cell_of(d.point.position))];
        next_.push_back(head);
        head = static_cast<Index>(darts_.size());
        darts_.push_back(d);
    }

 private:
    static bool is_too_near(const Dart& a, const Dart& b) {
        const double spacing = std::min(a.spacing, b.spacing);
        return squared_length(a.point.position - b.point.position) < spacing * spacing &&
               dot(a.point.normal, b.point.normal) > kOtherSide;
    }
    std::array<int, 3> cell_of(Vec3d p) const {
        std::array<int, 3> c{};
        for (std::size_t k = 0; k < 3; ++k)
            c[k] = std::clamp(static_cast<int>((p[k] - low_[k]) / cell_), 0, size_[k] - 1);
        return c;
    }
    std::size_t at(std::array<int, 3> c) const {
        return static_cast<std::size_t>((c[2] * size_[1] + c[1]) * size_[0] + c[0]);
    }
    Vec3d low_;
    double cell_;
    std::array<int, 3> size_{};
    std::vector<Index> head_, next_;
    std::vector<Dart> darts_;
};

// One round: as many points as fit with this spacing (of density 1), by block.
class Round {
 public:
    Round(const Field& field, double spacing, std::uint64_t num_darts)
        : field_(field),
          spacing_(spacing),
          largest_(spacing / std::sqrt(field.lowest_density())),
          blocks_(field.cut_into_blocks(largest_)),
          num_darts_(static_cast<double>(num_darts)),
          kept_(blocks_.begin.size() - 1) {}

    std::vector<SurfacePoint> run(const Context& context) {
        for (std::size_t phase = 0; phase < 8; ++phase) {
            const auto& list = blocks_.phase[phase];
            parallel_for(context, list.size(), 1,
                         [&](std::size_t k, std::size_t) { fill(list[k]); });
            report_progress(context, "demo", static_cast<double>(phase + 1) / 8.0);
        }
        std::vector<SurfacePoint> points;
        for (const auto& block : kept_)
            for (const Dart& d : block) points.push_back(d.point);
        return points;
    }

 private:
    std::uint64_t darts_before(std::size_t triangle) const {
        return static_cast<std::uint64_t>(num_darts_ * blocks_.mass_before(triangle) /
                                          field_.total_mass());
    }
    void fill(Index block) {
        const std::size_t first = blocks_.begin[block], last = blocks_.begin[block + 1];
        const std::uint64_t begin = darts_before(first), end = darts_before(last);
        std::vector<Dart> darts;
        Box box;
        for (std::uint64_t n = begin; n < end; ++n) {
            darts.push_back(field_.dart(blocks_, first, last, n, spacing_));
            box.extend(darts.back().point.position);
        }
        if (darts.empty()) return;
        box.low = box.low - Vec3d{largest_, largest_, largest_};
        box.high = box.high + Vec3d{largest_, largest_, largest_};
        Board board(box, largest_);
        put_neighbors(block, box, board);
        for (const Dart& d : darts) {
            if (!board.has_room(d)) continue;
            board.put(d);
            kept_[block].push_back(d);
        }
    }
    void put_neighbors(Index block, const Box& box, Board& board) const {
        const auto is_within = [&](Vec3d p) {
            return p.x >= box.low.x && p.y >= box.low.y && p.z >= box.low.z && p.x <= box.high.x &&
                   p.y <= box.high.y && p.z <= box.high.z;
        };
        const std::array<int, 3> c = blocks_.place(block);
        const std::array<int, 3>& size = blocks_.size;
        for (int z = std::max(0, c[2] - 1); z <= std::min(size[2] - 1, c[2] + 1); ++z)
            for (int y = std::max(0, c[1] - 1); y <= std::min(size[1] - 1, c[1] + 1); ++y)
                for (int x = std::max(0, c[0] - 1); x <= std::min(size[0] - 1, c[0] + 1); ++x)
                    for (const Dart& d : kept_[blocks_.at({x, y, z})])
                        if (is_within(d.point.position)) board.put(d);
    }

    const Field& field_;
    double spacing_, largest_;
    Blocks blocks_;
    double num_darts_;
    std::vector<std::vector<Dart>> kept_;  // by block
};

}  // namespace

std::vector<SurfacePoint> spread_points(const Mesh& mesh, double (*density)(Vec3d),
                                        std::uint64_t count, const Context& context) {
    const Field field(mesh, density);
    double aim = static_cast<double>(count);
    for (;;) {
        const double spacing = std::sqrt(kPacking * field.total_mass() / aim);
        Round round(field, spacing, kDarts * static_cast<std::uint64_t>(aim));
        std::vector<SurfacePoint> points = round.run(context);
        const auto found = static_cast<std::uint64_t>(points.size());
        if (found < count) {
            aim *= kOvershoot * static_cast<double>(count) / static_cast<double>(found);
            continue;
        }
        // Leave out the surplus, spread over all blocks.
        for (std::uint64_t k = 0; k < count; ++k) points[k] = points[k * found / count];
        points.resize(count);
        return points;
    }
}

}  // namespace pointbake
