// Weighted sample elimination [Yuksel15]: of five times as many random samples, the one that has
// the nearest and most neighbours goes, until the count is reached. Constants alpha, beta, gamma
// are the paper's. It departs in the random numbers: hashes of the sample's number, stratified over
// the surface's area.
#include "sample/blue_noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "core/hash.h"
#include "core/message.h"
#include "core/parallel.h"
#include "core/parallel_sort.h"

namespace pointbake {
namespace {

constexpr std::uint64_t kOversampling = 5;   // [Yuksel15] 4: more gains little
constexpr double kBeta = 0.65;               // [Yuksel15] Eq. 3; alpha = 8 is in weight_of()
constexpr std::uint64_t kSeed = 0x5eed;      // any
constexpr std::size_t kGrain = 2048;         // samples per chunk
constexpr std::size_t kStepsPerPoll = 4096;  // eliminations between two looks at the stop token

/// [Yuksel15] Eq. 2: the radius of the densest packing of `count` discs.
double largest_radius(double area, std::uint64_t count) {
    return std::sqrt(area / (2.0 * std::sqrt(3.0) * static_cast<double>(count)));
}

std::vector<SurfaceSample> random_samples(const Mesh& mesh, std::uint64_t count,
                                          const Context& context) {
    std::vector<double> area_up_to{0.0};
    for (Index t = 0; t < mesh.triangles.size(); ++t)
        area_up_to.push_back(area_up_to.back() + 0.5 * length(TriangleFrame(mesh, t).normal()));
    const double stratum = area_up_to.back() / static_cast<double>(count);

    std::vector<SurfaceSample> samples(count);
    parallel_for(context, count, kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const double at = (static_cast<double>(i) + random_unit(kSeed, 3 * i)) * stratum;
            const auto above = std::upper_bound(area_up_to.begin() + 1, area_up_to.end() - 1, at);
            const double r = std::sqrt(random_unit(kSeed, 3 * i + 1));
            const double s = random_unit(kSeed, 3 * i + 2);
            samples[i] = {static_cast<Index>(above - area_up_to.begin() - 1), 0.0F, r * (1.0 - s),
                          r * s};
        }
    });
    return samples;
}

using Cell = std::array<std::int64_t, 3>;

/// Cubic cells over samples, and for each the occupied ones around it. Samples are numbered cell by
/// cell: neighbours lie together in memory.
class CellGrid {
 public:
    CellGrid(std::span<const Vec3d> positions, double cell_size, const Context& context) {
        std::vector<std::pair<Cell, Index>> order(positions.size());
        parallel_for(context, positions.size(), kGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                for (std::size_t k = 0; k < 3; ++k) {
                    order[i].first[k] =
                        static_cast<std::int64_t>(std::floor(positions[i][k] / cell_size));
                    order[i].second = static_cast<Index>(i);
                }
        });
        parallel_sort(context, order);
        for (const auto& [cell, index] : order) {
            const auto number = static_cast<Index>(positions_.size());
            if (cells_.empty() || cells_.back() != cell) {
                cells_.push_back(cell);
                live_.push_back({number, number});
            }
            ++live_.back().end;
            items_.push_back(number);
            cell_of_.push_back(static_cast<Index>(cells_.size() - 1));
            positions_.push_back(positions[index]);
            original_.push_back(index);
        }
        link_cells(context);
    }

    std::size_t size() const { return positions_.size(); }
    Vec3d position(Index i) const { return positions_[i]; }
    /// Where sample i was in the constructor's array.
    Index original(Index i) const { return original_[i]; }

    /// Calls visit(j) for every sample in the cells around that of sample i, i included.
    template <class Visit>
    void for_each_around(Index i, Visit&& visit) const {
        for (const Index cell : around_[cell_of_[i]]) {
            if (cell == kInvalidIndex) break;
            for (Index k = live_[cell].begin; k < live_[cell].end; ++k) visit(items_[k]);
        }
    }

    void remove(Index i) {
        Range& live = live_[cell_of_[i]];
        const auto first = items_.begin() + live.begin;
        std::iter_swap(std::find(first, items_.begin() + live.end, i),
                       items_.begin() + live.end - 1);
        --live.end;
    }

 private:
    struct Range {
        Index begin, end;
    };

    void link_cells(const Context& context) {
        around_.resize(cells_.size());
        parallel_for(context, cells_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t c = begin; c < end; ++c) {
                std::size_t count = 0;
                around_[c].fill(kInvalidIndex);
                for (std::int64_t x = -1; x <= 1; ++x)
                    for (std::int64_t y = -1; y <= 1; ++y)
                        for (std::int64_t z = -1; z <= 1; ++z) {
                            const Cell cell{cells_[c][0] + x, cells_[c][1] + y, cells_[c][2] + z};
                            const auto it = std::lower_bound(cells_.begin(), cells_.end(), cell);
                            if (it != cells_.end() && *it == cell)
                                around_[c][count++] = static_cast<Index>(it - cells_.begin());
                        }
            }
        });
    }

    std::vector<Vec3d> positions_;
    std::vector<Index> original_, cell_of_;
    std::vector<Cell> cells_;
    std::vector<Index> items_;  ///< numbers of the samples, cell by cell
    std::vector<Range> live_;   ///< per cell: its samples in items_, less the removed ones
    std::vector<std::array<Index, 27>> around_;  ///< filled up with kInvalidIndex
};

/// Samples by weight, the heaviest on top. Weights only fall, so a sample's place may be out of
/// date until it comes to the top: far fewer moves than with every place kept right.
class WeightHeap {
 public:
    explicit WeightHeap(std::vector<double> weights) : weights_(std::move(weights)) {
        for (Index i = 0; i < weights_.size(); ++i) heap_.push_back({weights_[i], i});
        std::make_heap(heap_.begin(), heap_.end(), is_below);
    }

    std::size_t size() const { return heap_.size(); }
    std::span<const std::pair<double, Index>> items() const { return heap_; }
    void lower(Index i, double by) { weights_[i] -= by; }

    Index pop() {
        while (heap_.front().first != weights_[heap_.front().second])
            replace_top({weights_[heap_.front().second], heap_.front().second});
        const Index top = heap_.front().second;
        const auto last = heap_.back();
        heap_.pop_back();
        if (!heap_.empty()) replace_top(last);
        return top;
    }

 private:
    using Item = std::pair<double, Index>;  ///< (weight when placed, sample)

    static bool is_below(const Item& a, const Item& b) {
        return a.first < b.first || (a.first == b.first && a.second > b.second);
    }
    void replace_top(Item item) {
        std::size_t k = 0;
        for (std::size_t child; (child = 2 * k + 1) < heap_.size(); k = child) {
            if (child + 1 < heap_.size() && is_below(heap_[child], heap_[child + 1])) ++child;
            if (!is_below(item, heap_[child])) break;
            heap_[k] = heap_[child];
        }
        heap_[k] = item;
    }

    std::vector<double> weights_;
    std::vector<Item> heap_;
};

/// [Yuksel15] Eq. 1 and 3: what two samples at this distance weigh on each other.
struct PairWeight {
    double reach;     ///< 2 r_max
    double smallest;  ///< 2 r_min: nearer ones weigh no more

    PairWeight(double r_max, std::uint64_t count, std::uint64_t num_random) : reach(2.0 * r_max) {
        const double share = static_cast<double>(count) / static_cast<double>(num_random);
        smallest = reach * (1.0 - share * std::sqrt(share)) * kBeta;  // gamma = 1.5
    }
    double operator()(Vec3d a, Vec3d b) const {
        const double squared = squared_length(a - b);
        if (squared >= reach * reach) return 0.0;
        const double d = std::max(std::sqrt(squared), smallest);
        const double w = 1.0 - d / reach, w2 = w * w, w4 = w2 * w2;
        return w4 * w4;
    }
};

/// Which of the samples stay, in ascending order.
std::vector<Index> eliminate(std::span<const Vec3d> positions, double r_max, std::uint64_t count,
                             const Context& context) {
    CellGrid grid(positions, 2.0 * r_max, context);
    const PairWeight weight_of(r_max, count, grid.size());
    std::vector<double> weights(grid.size());
    parallel_for(context, grid.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (auto i = static_cast<Index>(begin); i < end; ++i)
            grid.for_each_around(i, [&](Index j) {
                if (j != i) weights[i] += weight_of(grid.position(i), grid.position(j));
            });
    });

    WeightHeap heap(std::move(weights));
    for (std::size_t step = 0; heap.size() > count; ++step) {
        if (step % kStepsPerPoll == 0) check_cancelled(context);
        const Index i = heap.pop();
        grid.remove(i);
        grid.for_each_around(i, [&](Index j) {
            const double w = weight_of(grid.position(i), grid.position(j));
            if (w > 0.0) heap.lower(j, w);
        });
    }
    std::vector<Index> kept;
    for (const auto& [weight, i] : heap.items()) kept.push_back(grid.original(i));
    std::sort(kept.begin(), kept.end());
    return kept;
}

}  // namespace

std::vector<SurfaceSample> sample_blue_noise(const Mesh& mesh, std::uint64_t count,
                                             const Context& context) {
    double area = 0.0;
    for (Index t = 0; t < mesh.triangles.size(); ++t)
        area += 0.5 * length(TriangleFrame(mesh, t).normal());
    const auto random = random_samples(mesh, kOversampling * count, context);
    std::vector<Vec3d> positions;
    positions.reserve(random.size());
    for (const SurfaceSample& s : random) positions.push_back(position(mesh, s));

    std::vector<SurfaceSample> samples;
    samples.reserve(count);
    for (const Index i : eliminate(positions, largest_radius(area, count), count, context)) {
        samples.push_back(random[i]);
        samples.back().area = static_cast<float>(area / static_cast<double>(count));
    }
    return samples;
}

}  // namespace pointbake
