// Delaunay triangulation by CGAL (GPL-3): no other file includes CGAL. Points go in by rounds of
// growing density, each in spatial order (the idea of [Amenta03]), so that a run can be cancelled
// between chunks. CGAL's containers have no defined order in parallel: cells are sorted by vertex
// ids before they are handed out.
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Delaunay_triangulation_cell_base_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_cell_base_with_info_3.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <memory>
#include <numeric>
#include <thread>

#include "core/message.h"
#include "core/parallel.h"
#include "reconstruct/delaunay.h"

namespace pointbake {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_3<Index, Kernel>;
using CellBase =
    CGAL::Triangulation_cell_base_with_info_3<Index, Kernel,
                                              CGAL::Delaunay_triangulation_cell_base_3<Kernel>>;
using Structure = CGAL::Triangulation_data_structure_3<VertexBase, CellBase, CGAL::Parallel_tag>;
using Triangulation = CGAL::Delaunay_triangulation_3<Kernel, Structure>;
using Point = Kernel::Point_3;
using Cell = Triangulation::Cell_handle;

// Each round holds 8 times as many points as all before it.
constexpr std::size_t kRoundGrowth = 8;
// Points between two looks at the stop token: 0.1 to 0.3 s of work.
constexpr std::size_t kChunk = 1U << 16;
// Fewer points, or fewer cores, go in sequentially. CGAL's threads spin on its locks: two of them
// gain 1.3x on an idle machine and lose 10x where other programs keep the cores busy.
constexpr std::size_t kParallelPoints = 1U << 18;
constexpr int kParallelCores = 4;
// The last chunk of a round may be small.
constexpr std::size_t kParallelChunk = 1U << 13;
// Cells of the lock grid along each axis, as CGAL's manual has it.
constexpr int kLockGrid = 50;
constexpr std::size_t kGrain = 1U << 14;

int num_cores() { return static_cast<int>(std::thread::hardware_concurrency()); }

struct IdSource {
    std::span<const Index> subset;
    std::size_t count;
    Index operator[](std::size_t i) const {
        return subset.empty() ? static_cast<Index>(i) : subset[i];
    }
};

class Inserter {
 public:
    Inserter(Triangulation& triangulation, std::span<const Vec3d> points, const Context& context)
        : triangulation_(triangulation),
          points_(points),
          context_(context),
          arena_(std::min(num_threads(context), num_cores())) {}

    void add(Index id) {
        batch_.emplace_back(to_point(points_[id]), id);
        if (batch_.size() == kChunk) flush();
    }

    void flush() {
        check_cancelled(context_);
        if (triangulation_.is_parallel() && batch_.size() >= kParallelChunk) {
            arena_.execute([&] { triangulation_.insert(batch_.begin(), batch_.end()); });
        } else {
            insert_in_order();
        }
        batch_.clear();
    }

 private:
    static Point to_point(Vec3d p) { return {p.x, p.y, p.z}; }

    // Each point starts its search at the one before it.
    void insert_in_order() {
        auto hint = triangulation_.infinite_vertex();
        for (const auto& [point, id] : batch_) {
            hint = hint == triangulation_.infinite_vertex() ? triangulation_.insert(point)
                                                            : triangulation_.insert(point, hint);
            hint->info() = id;
        }
    }

    Triangulation& triangulation_;
    std::span<const Vec3d> points_;
    const Context& context_;
    tbb::task_arena arena_;
    std::vector<std::pair<Point, Index>> batch_;
};

void insert_in_rounds(Triangulation& triangulation, std::span<const Vec3d> points, IdSource ids,
                      const Context& context) {
    Inserter inserter(triangulation, points, context);
    std::size_t stride = 1;
    while (stride * kRoundGrowth < ids.count) stride *= kRoundGrowth;
    for (std::size_t done = 0; stride > 0; stride /= kRoundGrowth) {
        const std::size_t coarser = stride * kRoundGrowth;
        for (std::size_t i = 0; i < ids.count; i += stride) {
            if (done > 0 && i % coarser == 0) continue;  // went in with an earlier round
            inserter.add(ids[i]);
        }
        inserter.flush();
        done = stride;
    }
}

// The cell's vertices, ascending but for the last two. order[k] is CGAL's place of vertex k.
std::array<int, 4> canonical_order(const Cell& cell) {
    std::array<int, 4> order{0, 1, 2, 3};
    std::sort(order.begin(), order.end(),
              [&](int a, int b) { return cell->vertex(a)->info() < cell->vertex(b)->info(); });
    int inversions = 0;
    for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = i + 1; j < 4; ++j) inversions += order[i] > order[j] ? 1 : 0;
    if (inversions % 2 == 1) std::swap(order[2], order[3]);
    return order;
}

Index smallest_vertex(const Cell& cell) {
    return std::min(std::min(cell->vertex(0)->info(), cell->vertex(1)->info()),
                    std::min(cell->vertex(2)->info(), cell->vertex(3)->info()));
}

// Finite cells in ascending order of their vertices: buckets by the smallest, then sorted inside.
std::vector<Cell> sorted_cells(const Triangulation& triangulation, std::size_t num_points,
                               const Context& context) {
    std::vector<Index> begin(num_points + 1, 0);
    for (auto c : triangulation.finite_cell_handles()) ++begin[smallest_vertex(c) + 1];
    check_cancelled(context);
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<Cell> cells(begin.back());
    std::vector<Index> next(begin.begin(), begin.end() - 1);
    for (auto c : triangulation.finite_cell_handles()) cells[next[smallest_vertex(c)]++] = c;
    const auto key = [](const Cell& c) {
        const auto order = canonical_order(c);
        std::array<Index, 4> ids;
        for (std::size_t k = 0; k < 4; ++k) ids[k] = c->vertex(order[k])->info();
        return ids;
    };
    parallel_for(context, num_points, kGrain, [&](std::size_t first, std::size_t last) {
        std::vector<std::pair<std::array<Index, 4>, Cell>> bucket;
        for (std::size_t v = first; v < last; ++v) {
            bucket.clear();
            for (Index i = begin[v]; i < begin[v + 1]; ++i)
                bucket.emplace_back(key(cells[i]), cells[i]);
            std::sort(bucket.begin(), bucket.end(),
                      [](const auto& a, const auto& b) { return a.first < b.first; });
            for (Index i = begin[v]; i < begin[v + 1]; ++i) {
                cells[i] = bucket[i - begin[v]].second;
                cells[i]->info() = i;
            }
        }
    });
    return cells;
}

Delaunay flat_arrays(const Triangulation& triangulation, std::size_t num_points,
                     const Context& context) {
    Delaunay result;
    const auto infinite = triangulation.infinite_vertex();
    infinite->info() = kInvalidIndex;
    const std::vector<Cell> cells = sorted_cells(triangulation, num_points, context);
    result.cells.resize(cells.size());
    result.neighbors.resize(cells.size());
    parallel_for(context, cells.size(), kGrain, [&](std::size_t first, std::size_t last) {
        for (std::size_t c = first; c < last; ++c) {
            const auto order = canonical_order(cells[c]);
            for (std::size_t k = 0; k < 4; ++k) {
                result.cells[c][k] = cells[c]->vertex(order[k])->info();
                const Cell n = cells[c]->neighbor(order[k]);
                result.neighbors[c][k] = n->has_vertex(infinite) ? kInvalidIndex : n->info();
            }
        }
    });
    return result;
}

}  // namespace

bool has_delaunay() { return true; }

Delaunay delaunay(std::span<const Vec3d> points, const Context& context,
                  std::span<const Index> subset) {
    const IdSource ids{subset, subset.empty() ? points.size() : subset.size()};
    if (ids.count < 4) return {};
    std::unique_ptr<Triangulation::Lock_data_structure> locks;
    if (std::min(num_threads(context), num_cores()) >= kParallelCores &&
        ids.count >= kParallelPoints) {
        Box box;
        for (std::size_t i = 0; i < ids.count; ++i) box.extend(points[ids[i]]);
        locks = std::make_unique<Triangulation::Lock_data_structure>(
            CGAL::Bbox_3(box.low.x, box.low.y, box.low.z, box.high.x, box.high.y, box.high.z),
            kLockGrid);
    }
    Triangulation triangulation(Kernel(), locks.get());
    insert_in_rounds(triangulation, points, ids, context);
    if (triangulation.dimension() < 3) return {};
    return flat_arrays(triangulation, points.size(), context);
}

}  // namespace pointbake
