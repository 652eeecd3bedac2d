#include "texture/chart_overlap.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

namespace pointbake {
namespace {

constexpr double kCellsPerTriangle = 16.0;  // of the grid on which near sheets are looked for
constexpr int kMostCells = 512;             // per side of the grid on which crossings are

// A side of a triangle across which the chart ends.
struct BorderSide {
    Index triangle;
    Vec2d a, b;
    bool crosses(const BorderSide& other) const {
        const Vec2d d = b - a, e = other.b - other.a;
        return cross(d, other.a - a) * cross(d, other.b - a) < 0.0 &&
               cross(e, a - other.a) * cross(e, b - other.a) < 0.0;
    }
};

// The corner of a triangle at a vertex: a wedge between two directions, counter-clockwise.
struct Wedge {
    Index vertex, triangle;
    Vec2d from, to;
    bool holds(Vec2d d) const { return cross(from, d) > 0.0 && cross(d, to) > 0.0; }
    bool overlaps(const Wedge& other) const {
        const Vec2d middle = from / length(from) + to / length(to);
        return holds(other.from) || holds(other.to) || other.holds(from) || other.holds(to) ||
               other.holds(middle);
    }
};

struct Cell {
    Index triangle = kInvalidIndex;
    Vec3d place;  // on the surface
};

class OverlapFinder {
 public:
    OverlapFinder(const Mesh& mesh, std::span<const std::array<Index, 3>> neighbors,
                  std::span<const Index> triangles, const FlatCorners& corners)
        : mesh_(mesh), neighbors_(neighbors), triangles_(triangles), corners_(corners) {}

    std::optional<std::pair<Index, Index>> run() const {
        auto found = find_crossing();
        if (!found) found = find_wrapped_vertex();
        return found ? found : find_near_sheets();
    }

 private:
    double area_of(Index t) const {
        const Triangle& tri = mesh_.triangles[t];
        const Vec3d a = mesh_.positions[tri[0]];
        return 0.5 * length(cross(mesh_.positions[tri[1]] - a, mesh_.positions[tri[2]] - a));
    }

    std::vector<BorderSide> border_of() const {
        std::vector<BorderSide> out;
        const auto is_member = [&](Index t) {
            return std::binary_search(triangles_.begin(), triangles_.end(), t);
        };
        for (std::size_t i = 0; i < triangles_.size(); ++i)
            for (std::size_t k = 0; k < 3; ++k) {
                const Index next = neighbors_[triangles_[i]][k];
                if (next == kInvalidIndex || !is_member(next))
                    out.push_back({triangles_[i], corners_[i][k], corners_[i][(k + 1) % 3]});
            }
        return out;
    }

    // Two triangles whose sides on the border cross. Where none do, a chart without triangles that
    // are turned over covers no place twice.
    std::optional<std::pair<Index, Index>> find_crossing() const {
        const std::vector<BorderSide> border = border_of();
        Vec2d low{HUGE_VAL, HUGE_VAL}, high{-HUGE_VAL, -HUGE_VAL};
        double around = 0.0;
        for (const BorderSide& side : border) {
            low = {std::min(low.x, side.a.x), std::min(low.y, side.a.y)};
            high = {std::max(high.x, side.a.x), std::max(high.y, side.a.y)};
            around += length(side.b - side.a);
        }
        const double size = std::max(high.x - low.x, high.y - low.y);
        const double cell =
            std::max(around / static_cast<double>(std::max<std::size_t>(border.size(), 1)),
                     size / kMostCells);
        if (!(cell > 0.0)) return std::nullopt;
        const auto column = [&](double x) { return static_cast<int>((x - low.x) / cell); };
        const auto row = [&](double y) { return static_cast<int>((y - low.y) / cell); };
        const int width = column(high.x) + 1, height = row(high.y) + 1;
        std::vector<std::vector<Index>> grid(static_cast<std::size_t>(width) *
                                             static_cast<std::size_t>(height));
        for (Index i = 0; i < border.size(); ++i) {
            const auto [left, right] = std::minmax(border[i].a.x, border[i].b.x);
            const auto [top, bottom] = std::minmax(border[i].a.y, border[i].b.y);
            for (int y = row(top); y <= row(bottom); ++y)
                for (int x = column(left); x <= column(right); ++x) {
                    std::vector<Index>& here =
                        grid[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                             static_cast<std::size_t>(x)];
                    for (const Index j : here)
                        if (border[i].crosses(border[j]))
                            return std::pair{border[j].triangle, border[i].triangle};
                    here.push_back(i);
                }
        }
        return std::nullopt;
    }

    // Two triangles that cover the same at a vertex they share, where borders meet without crossing
    // beside it.
    std::optional<std::pair<Index, Index>> find_wrapped_vertex() const {
        std::vector<Wedge> wedges;
        for (std::size_t i = 0; i < triangles_.size(); ++i) {
            const Index t = triangles_[i];
            if (!(area_of(t) > 0.0)) continue;
            const std::array<Vec2d, 3>& c = corners_[i];
            for (std::size_t k = 0; k < 3; ++k)
                wedges.push_back(
                    {mesh_.triangles[t][k], t, c[(k + 1) % 3] - c[k], c[(k + 2) % 3] - c[k]});
        }
        std::stable_sort(wedges.begin(), wedges.end(),
                         [](const Wedge& a, const Wedge& b) { return a.vertex < b.vertex; });
        for (std::size_t i = 0; i < wedges.size(); ++i)
            for (std::size_t j = i + 1; j < wedges.size() && wedges[j].vertex == wedges[i].vertex;
                 ++j)
                if (wedges[i].overlaps(wedges[j]))
                    return std::pair{wedges[i].triangle, wedges[j].triangle};
        return std::nullopt;
    }

    // Two triangles that nearly touch in the plane of their chart, but lie far apart on the
    // surface.
    std::optional<std::pair<Index, Index>> find_near_sheets() const {
        Vec2d low{HUGE_VAL, HUGE_VAL}, high{-HUGE_VAL, -HUGE_VAL};
        double area = 0.0;
        for (const Index t : triangles_) area += area_of(t);
        for (const auto& corners : corners_)
            for (const Vec2d x : corners) {
                low = {std::min(low.x, x.x), std::min(low.y, x.y)};
                high = {std::max(high.x, x.x), std::max(high.y, x.y)};
            }
        constexpr double kLeastCells = 256.0;
        const double wanted =
            std::max(kLeastCells, kCellsPerTriangle * static_cast<double>(triangles_.size()));
        const double cell =
            std::max(std::sqrt(area / wanted), 1e-3 * std::max(high.x - low.x, high.y - low.y));
        if (!(cell > 0.0)) return std::nullopt;
        const int width = static_cast<int>((high.x - low.x) / cell) + 1,
                  height = static_cast<int>((high.y - low.y) / cell) + 1;
        std::vector<Cell> grid(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
        const auto at = [&](int x, int y) -> Cell& {
            return grid[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                        static_cast<std::size_t>(x)];
        };
        constexpr double kSteps = 4.0;  // cells: farther apart is another sheet
        std::optional<std::pair<Index, Index>> found;
        const auto compare = [&](const Cell& a, const Cell& b, double steps) {
            if (a.triangle != kInvalidIndex && b.triangle != kInvalidIndex &&
                squared_length(a.place - b.place) > steps * steps * cell * cell)
                found = {a.triangle, b.triangle};
        };
        for (std::size_t i = 0; i < triangles_.size(); ++i)
            for_each_cell(i, low, cell, width, height,
                          [&](int x, int y, Vec3d place) { at(x, y) = {triangles_[i], place}; });
        constexpr int kNear = 2;  // cells between sheets
        for (int y = 0; y < height && !found; ++y)
            for (int x = 0; x < width; ++x) {
                if (at(x, y).triangle == kInvalidIndex) continue;
                for (int j = 0; j <= kNear; ++j)
                    for (int i = -kNear; i <= kNear; ++i) {
                        if ((j == 0 && i <= 0) || x + i < 0 || x + i >= width || y + j >= height)
                            continue;
                        compare(at(x, y), at(x + i, y + j), kSteps + std::abs(i) + j);
                    }
            }
        return found;
    }

    // Visits the cells whose middle a triangle covers, with the place on the surface.
    template <class Visit>
    void for_each_cell(std::size_t i, Vec2d low, double cell, int width, int height,
                       Visit&& visit) const {
        std::array<Vec2d, 3> c;
        for (std::size_t k = 0; k < 3; ++k) c[k] = (corners_[i][k] - low) / cell - Vec2d{0.5, 0.5};
        const double whole = cross(c[1] - c[0], c[2] - c[0]);
        if (!(std::fabs(whole) > 0.0)) return;
        const auto [left, right] = std::minmax({c[0].x, c[1].x, c[2].x});
        const auto [top, bottom] = std::minmax({c[0].y, c[1].y, c[2].y});
        const Triangle& tri = mesh_.triangles[triangles_[i]];
        const int x0 = std::max(0, static_cast<int>(std::ceil(left))),
                  x1 = std::min(width - 1, static_cast<int>(std::floor(right)));
        const int y0 = std::max(0, static_cast<int>(std::ceil(top))),
                  y1 = std::min(height - 1, static_cast<int>(std::floor(bottom)));
        for (int y = y0; y <= y1; ++y)
            for (int x = x0; x <= x1; ++x) {
                const Vec2d p{static_cast<double>(x), static_cast<double>(y)};
                const double b0 = cross(c[1] - p, c[2] - p) / whole,
                             b1 = cross(c[2] - p, c[0] - p) / whole, b2 = 1.0 - b0 - b1;
                if (std::min({b0, b1, b2}) >= 0.0)
                    visit(x, y,
                          mesh_.positions[tri[0]] * b0 + mesh_.positions[tri[1]] * b1 +
                              mesh_.positions[tri[2]] * b2);
            }
    }

    const Mesh& mesh_;
    std::span<const std::array<Index, 3>> neighbors_;
    std::span<const Index> triangles_;
    const FlatCorners& corners_;
};

}  // namespace

std::optional<std::pair<Index, Index>> find_overlap(const Mesh& mesh,
                                                    std::span<const std::array<Index, 3>> neighbors,
                                                    std::span<const Index> triangles,
                                                    const FlatCorners& corners) {
    return OverlapFinder(mesh, neighbors, triangles, corners).run();
}

}  // namespace pointbake
