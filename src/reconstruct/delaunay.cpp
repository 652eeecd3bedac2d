// Incremental insertion [Bowyer81], [Watson81] into flat arrays. Points go in by rounds of growing
// density, each in spatial order (the idea of [Amenta03]), so that the search for a point starts
// near it; exact predicates and a symbolic perturbation leave the order of insertion without
// influence on the cells. They are sorted by vertex ids before they are handed out.
#include "reconstruct/delaunay.h"

#include <algorithm>
#include <numeric>
#include <optional>

#include "core/message.h"
#include "core/parallel.h"
#include "reconstruct/predicates.h"
#include "reconstruct/tetrahedra.h"

namespace pointbake {
namespace {

// Each round holds 8 times as many points as all before it.
constexpr std::size_t kRoundGrowth = 8;
// Points between two looks at the stop token: less than 0.3 s of work.
constexpr std::size_t kPollInterval = 1U << 16;
// Cells there is room for from the start; what is not used takes no memory.
constexpr std::size_t kCellsPerPoint = 8;
constexpr std::size_t kGrain = 1U << 14;
// Cavities with more facets are rare, and too large for a table of all pairs of vertices.
constexpr std::size_t kTableFacets = 1U << 10;
// Facets are numbered, four to a cell.
constexpr std::size_t kMostCells = kInvalidIndex / 4;
// The vertex of all cells outside the convex hull.
constexpr Index kInfinite = kInvalidIndex;

struct Cell {
    std::array<Index, 4> vertices;   // positively oriented
    std::array<HalfFacet, 4> mates;  // the facet opposite each, seen from the other side
};

std::size_t find_slot(const std::array<Index, 4>& vertices, Index v) {
    return vertices[0] == v ? 0 : (vertices[1] == v ? 1 : (vertices[2] == v ? 2 : 3));
}

bool is_infinite(const Cell& cell) {
    const auto& v = cell.vertices;
    return v[0] == kInfinite || v[1] == kInfinite || v[2] == kInfinite || v[3] == kInfinite;
}

class Triangulator {
 public:
    Triangulator(std::span<const Vec3d> points, std::size_t count)
        : points_(points), numbers_(points.size() + 1) {
        cells_.reserve(kCellsPerPoint * count);
        states_.reserve(kCellsPerPoint * count);
    }

    // The first cell, and those around it.
    void start(const std::array<Index, 4>& corners) {
        add_cell(corners);
        for (std::size_t i = 0; i < 4; ++i) {
            std::array<Index, 4> outer = corners;
            outer[i] = kInfinite;
            std::swap(outer[(i + 1) % 4], outer[(i + 2) % 4]);
            add_cell(outer);
        }
        for (Index c = 0; c < 5; ++c)
            for (Index d = 0; d < 5; ++d)
                if (c != d) join_first(c, d);
    }

    // A point in the place of another one is left out.
    void insert(Index v) {
        const Index at = locate(points_[v]);
        if (has_corner_at(cells_[at], points_[v])) return;
        find_cavity(at, points_[v]);
        fill_cavity(v);
    }

    // Those that are no more count as infinite.
    std::vector<Cell> take_cells() {
        for (Index c : free_) cells_[c].vertices.fill(kInfinite);
        return std::move(cells_);
    }

 private:
    enum State : std::uint8_t { kUnseen, kInCavity, kOutside };

    Index add_cell(const std::array<Index, 4>& vertices) {
        if (cells_.size() == kMostCells)
            fail(ErrorCode::kLimit,
                 "the triangulation of {} points needs more than {} tetrahedra: --subsample them",
                 points_.size(), kMostCells);
        cells_.push_back({vertices, {}});
        states_.push_back(kUnseen);
        return static_cast<Index>(cells_.size() - 1);
    }

    // Of any two of the first five cells each lacks one of the other's vertices.
    void join_first(Index c, Index d) {
        const auto lacks = [&](Index cell, Index v) {
            const auto& vertices = cells_[cell].vertices;
            return std::find(vertices.begin(), vertices.end(), v) == vertices.end();
        };
        for (std::size_t i = 0; i < 4; ++i) {
            if (!lacks(d, cells_[c].vertices[i])) continue;
            for (Index k = 0; k < 4; ++k)
                if (lacks(c, cells_[d].vertices[k])) cells_[c].mates[i] = d * 4 + k;
        }
    }

    const Vec3d& corner(const Cell& cell, std::size_t i) const { return points_[cell.vertices[i]]; }

    bool has_corner_at(const Cell& cell, const Vec3d& p) const {
        return std::any_of(cell.vertices.begin(), cell.vertices.end(),
                           [&](Index v) { return v != kInfinite && points_[v] == p; });
    }

    bool is_beyond(const Cell& cell, std::size_t i, const Vec3d& p) const {
        const auto& k = kFacetCorners[i];
        return orientation(corner(cell, k[0]), corner(cell, k[1]), corner(cell, k[2]), p) > 0;
    }

    // A cell that contains p, or an infinite one whose facet p lies beyond. Walks from the newest
    // one.
    Index locate(const Vec3d& p) const {
        Index at = newest_, from = kInvalidIndex;
        if (is_infinite(cells_[at]))
            at = cells_[at].mates[find_slot(cells_[at].vertices, kInfinite)] / 4;
        while (!is_infinite(cells_[at])) {
            const Cell& cell = cells_[at];
            std::size_t exit = 0;
            while (exit < 4 && (cell.mates[exit] / 4 == from || !is_beyond(cell, exit, p))) ++exit;
            if (exit == 4) break;
            from = at;
            at = cell.mates[exit] / 4;
        }
        return at;
    }

    // Whether p is in the circumsphere.
    bool is_in_conflict(const Cell& cell, const Vec3d& p) const {
        if (!is_infinite(cell))
            return is_in_sphere(corner(cell, 0), corner(cell, 1), corner(cell, 2), corner(cell, 3),
                                p);
        // Seen from the infinite vertex, the hull's facet is the one opposite to it.
        const auto& k = kFacetCorners[find_slot(cell.vertices, kInfinite)];
        const Vec3d &a = corner(cell, k[0]), &b = corner(cell, k[1]), &c = corner(cell, k[2]);
        const int side = orientation(a, b, c, p);
        return side < 0 || (side == 0 && is_in_circle(a, b, c, p));
    }

    void find_cavity(Index first, const Vec3d& p) {
        cavity_.assign(1, first);
        rim_.clear();
        states_[first] = kInCavity;
        for (std::size_t head = 0; head < cavity_.size(); ++head) {
            const Index c = cavity_[head];
            for (Index i = 0; i < 4; ++i) {
                const Index n = cells_[c].mates[i] / 4;
                if (states_[n] == kUnseen) {
                    const bool conflicts = is_in_conflict(cells_[n], p);
                    states_[n] = conflicts ? kInCavity : kOutside;
                    if (conflicts) cavity_.push_back(n);
                }
                if (states_[n] == kOutside) rim_.push_back(c * 4 + i);
            }
        }
    }

    // A cell from the point to each facet of the rim.
    void fill_cavity(Index v) {
        new_cells_.clear();
        for (const HalfFacet facet : rim_) {
            const HalfFacet outer = cells_[facet / 4].mates[facet % 4];
            const Index c = new_cell(facet, v);
            cells_[c].mates[facet % 4] = outer;
            cells_[outer / 4].mates[outer % 4] = c * 4 + facet % 4;
            states_[outer / 4] = kUnseen;
            new_cells_.push_back(c);
        }
        if (rim_.size() <= kTableFacets)
            join_by_table();
        else
            for (const HalfFacet facet : rim_) join_by_turning(facet);
        for (const Index c : cavity_) states_[c] = kUnseen;
        free_.insert(free_.end(), cavity_.begin(), cavity_.end());
    }

    Index new_cell(HalfFacet facet, Index v) {
        std::array<Index, 4> vertices = cells_[facet / 4].vertices;
        vertices[facet % 4] = v;
        if (free_.empty()) return newest_ = add_cell(vertices);
        newest_ = free_.back();
        free_.pop_back();
        cells_[newest_].vertices = vertices;
        return newest_;
    }

    // Each edge of the rim is run along once in either direction: a table by its ends says which
    // facet of which new cell lies there. The rim is a sphere, whose vertices follow from its
    // facets.
    void join_by_table() {
        const std::size_t stride = rim_.size() / 2 + 2;
        if (table_.size() < stride * stride) table_.resize(stride * stride);
        rim_vertices_.clear();
        ends_.clear();
        for (std::size_t k = 0; k < rim_.size(); ++k) {
            const Cell& cell = cells_[new_cells_[k]];
            const auto& slots = kFacetCorners[rim_[k] % 4];
            auto& ends = ends_.emplace_back();
            for (std::size_t i = 0; i < 3; ++i) ends[i] = number_in_rim(cell.vertices[slots[i]]);
            for (std::size_t i = 0; i < 3; ++i)
                table_[ends[(i + 1) % 3] * stride + ends[(i + 2) % 3]] =
                    new_cells_[k] * 4 + static_cast<Index>(slots[i]);
        }
        for (std::size_t k = 0; k < rim_.size(); ++k) {
            auto& mates = cells_[new_cells_[k]].mates;
            const auto& slots = kFacetCorners[rim_[k] % 4];
            for (std::size_t i = 0; i < 3; ++i)
                mates[slots[i]] = table_[ends_[k][(i + 2) % 3] * stride + ends_[k][(i + 1) % 3]];
        }
    }

    // Numbers of earlier cavities are told by what they stand for now.
    Index number_in_rim(Index v) {
        Index& number = numbers_[v == kInfinite ? points_.size() : v];
        if (number >= rim_vertices_.size() || rim_vertices_[number] != v) {
            number = static_cast<Index>(rim_vertices_.size());
            rim_vertices_.push_back(v);
        }
        return number;
    }

    // The new cell at a facet of the rim: the facet's outer side knows it.
    Index new_cell_at(HalfFacet facet) const {
        const HalfFacet outer = cells_[facet / 4].mates[facet % 4];
        return cells_[outer / 4].mates[outer % 4] / 4;
    }

    // The same for one cell, without a table: around each edge of its facet of the rim, through the
    // cavity, lies another such facet.
    void join_by_turning(HalfFacet facet) {
        const Index cell = new_cell_at(facet);
        const std::size_t own = facet % 4;
        for (std::size_t i = 0; i < 4; ++i) {
            if (i == own) continue;
            // Left through `exit`; `pivot` is the vertex opposite to where the turn came in.
            Index at = facet / 4;
            std::size_t exit = i, pivot = own;
            for (;;) {
                const HalfFacet entered = cells_[at].mates[exit];
                if (states_[entered / 4] != kInCavity) break;
                const Index third = cells_[at].vertices[pivot];
                at = entered / 4;
                pivot = entered % 4;
                exit = find_slot(cells_[at].vertices, third);
            }
            cells_[cell].mates[i] =
                new_cell_at(at * 4 + static_cast<Index>(exit)) * 4 + static_cast<Index>(pivot);
        }
    }

    std::span<const Vec3d> points_;
    std::vector<Cell> cells_;
    std::vector<std::uint8_t> states_;
    std::vector<Index> free_;  // cells that are no more
    Index newest_ = 0;
    std::vector<Index> cavity_;
    std::vector<HalfFacet> rim_;              // seen from the cavity
    std::vector<Index> new_cells_;            // at each facet of the rim
    std::vector<std::array<Index, 3>> ends_;  // of its edges, as numbers in the rim
    std::vector<Index> rim_vertices_, numbers_, table_;
};

struct IdSource {
    std::span<const Index> subset;
    std::size_t count;
    Index operator[](std::size_t i) const {
        return subset.empty() ? static_cast<Index>(i) : subset[i];
    }
};

// Four points that span a volume, positively oriented; none if there are none.
std::optional<std::array<Index, 4>> find_corners(std::span<const Vec3d> points, IdSource ids) {
    const Vec3d &a = points[ids[0]], &b = points[ids[1]];
    std::size_t i = 2;
    while (i < ids.count && are_collinear(a, b, points[ids[i]])) ++i;
    if (i == ids.count) return std::nullopt;
    const Vec3d& c = points[ids[i]];
    for (std::size_t j = i + 1; j < ids.count; ++j) {
        const int side = orientation(a, b, c, points[ids[j]]);
        if (side > 0) return std::array{ids[0], ids[1], ids[i], ids[j]};
        if (side < 0) return std::array{ids[1], ids[0], ids[i], ids[j]};
    }
    return std::nullopt;
}

std::vector<Cell> triangulate(std::span<const Vec3d> points, IdSource ids,
                              const std::array<Index, 4>& corners, const Context& context) {
    Triangulator triangulator(points, ids.count);
    triangulator.start(corners);
    std::size_t stride = 1, num_steps = 0;
    while (stride * kRoundGrowth < ids.count) stride *= kRoundGrowth;
    for (bool is_first = true; stride > 0; stride /= kRoundGrowth, is_first = false) {
        const std::size_t coarser = stride * kRoundGrowth;
        for (std::size_t i = 0; i < ids.count; i += stride) {
            if (!is_first && i % coarser == 0) continue;  // went in with an earlier round
            if (num_steps++ % kPollInterval == 0) check_cancelled(context);
            if (find_slot(corners, ids[i]) == 3 && corners[3] != ids[i])
                triangulator.insert(ids[i]);
        }
    }
    return triangulator.take_cells();
}

// Vertices ascending but for the last two, which keep the orientation; mates become neighbours.
void make_canonical(Cell& cell) {
    auto& [vertices, mates] = cell;
    bool is_odd = false;
    const auto order = [&](std::size_t i, std::size_t j) {
        if (vertices[i] < vertices[j]) return;
        std::swap(vertices[i], vertices[j]);
        std::swap(mates[i], mates[j]);
        is_odd = !is_odd;
    };
    order(0, 1), order(2, 3), order(0, 2), order(1, 3), order(1, 2);
    if (is_odd) std::swap(vertices[2], vertices[3]), std::swap(mates[2], mates[3]);
    for (HalfFacet& m : mates) m /= 4;
}

// Finite cells in ascending order of their vertices: buckets by the first, then sorted inside.
std::vector<Index> sort_cells(const std::vector<Cell>& cells, std::size_t num_points,
                              const Context& context) {
    std::vector<Index> begin(num_points + 1, 0);
    for (const Cell& c : cells)
        if (!is_infinite(c)) ++begin[c.vertices[0] + 1];
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<Index> order(begin.back()), next(begin.begin(), begin.end() - 1);
    for (Index c = 0; c < cells.size(); ++c)
        if (!is_infinite(cells[c])) order[next[cells[c].vertices[0]]++] = c;
    parallel_for(context, num_points, kGrain, [&](std::size_t first, std::size_t last) {
        for (std::size_t v = first; v < last; ++v)
            std::sort(order.begin() + begin[v], order.begin() + begin[v + 1],
                      [&](Index a, Index b) { return cells[a].vertices < cells[b].vertices; });
    });
    return order;
}

Delaunay flat_arrays(std::vector<Cell> cells, std::size_t num_points, const Context& context) {
    parallel_for(context, cells.size(), kGrain, [&](std::size_t first, std::size_t last) {
        for (std::size_t c = first; c < last; ++c) make_canonical(cells[c]);
    });
    const std::vector<Index> order = sort_cells(cells, num_points, context);
    std::vector<Index> rank(cells.size(), kInvalidIndex);
    for (Index k = 0; k < order.size(); ++k) rank[order[k]] = k;
    Delaunay result;
    result.cells.resize(order.size());
    result.neighbors.resize(order.size());
    parallel_for(context, order.size(), kGrain, [&](std::size_t first, std::size_t last) {
        for (std::size_t k = first; k < last; ++k) {
            const Cell& cell = cells[order[k]];
            result.cells[k] = cell.vertices;
            for (std::size_t i = 0; i < 4; ++i) result.neighbors[k][i] = rank[cell.mates[i]];
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
    const auto corners = find_corners(points, ids);
    if (!corners) return {};
    return flat_arrays(triangulate(points, ids, *corners, context), points.size(), context);
}

}  // namespace pointbake
