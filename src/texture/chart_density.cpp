#include "texture/chart_density.h"

#include <algorithm>
#include <cmath>
#include <queue>
#include <tuple>

#include "core/union_find.h"

namespace pointbake {
namespace {

// Texels that one more chart must save: the block of 32 x 32 that mip levels from afar see of it.
constexpr double kPriceOfChart = 1024.0;
// Parts whose densities differ by less than this factor are one from the start.
constexpr double kAlike = 1.0905077326652577;  // 2^(1/8)

struct Part {
    double area = 0.0, border = 0.0, wanted = 0.0;
    std::size_t num_triangles = 0;
    int version = 0;
    std::vector<std::pair<Index, double>> neighbors;  // parts beside it, length of the side shared

    // Texels larger than the triangles would show what lies far around.
    double density() const {
        const double least =
            area > 0.0 ? std::sqrt(static_cast<double>(num_triangles) / (2.0 * area)) : 0.0;
        return std::max(wanted, least);
    }
    double cost(double gutter) const {
        return chart_texels(area, border, density(), gutter) + kPriceOfChart;
    }
};

class Splitter {
 public:
    Splitter(Charts& charts, std::span<const double> wanted, double gutter,
             std::span<const std::array<Index, 3>> neighbors)
        : charts_(charts),
          wanted_(wanted),
          gutter_(gutter),
          neighbors_(neighbors),
          groups_(wanted.size()),
          parts_(wanted.size()) {}

    void run() {
        unite_alike();
        make_parts();
        for (Index p = 0; p < parts_.size(); ++p) offer_all(p);
        while (!offers_.empty()) {
            const Offer best = offers_.top();
            offers_.pop();
            if (parts_[best.a].version != best.version_a ||
                parts_[best.b].version != best.version_b)
                continue;
            merge(best.a, best.b);
        }
        number_charts();
    }

 private:
    struct Offer {
        double saving;
        Index a, b;  // a < b
        int version_a, version_b;
        bool operator<(const Offer& o) const {
            return std::tie(saving, o.a, o.b) < std::tie(o.saving, a, b);
        }
    };

    double side(Index t, std::size_t k) const {
        return length(charts_.corners[t][(k + 1) % 3] - charts_.corners[t][k]);
    }
    /// The neighbour behind a side if it is of the same chart.
    Index inside(Index t, std::size_t k) const {
        const Index next = neighbors_[t][k];
        return next != kInvalidIndex && charts_.of_triangle[next] == charts_.of_triangle[t]
                   ? next
                   : kInvalidIndex;
    }

    void unite_alike() {
        for (Index t = 0; t < wanted_.size(); ++t)
            for (std::size_t k = 0; k < 3; ++k) {
                const Index next = inside(t, k);
                if (next == kInvalidIndex || next < t) continue;
                const auto [low, high] = std::minmax(wanted_[t], wanted_[next]);
                if (high <= low * kAlike) groups_.unite(t, next);
            }
    }

    void make_parts() {
        for (Index t = 0; t < wanted_.size(); ++t) {
            const Index own = groups_.find(t);
            Part& part = parts_[own];
            const std::array<Vec2d, 3>& x = charts_.corners[t];
            part.area += 0.5 * std::fabs(cross(x[1] - x[0], x[2] - x[0]));
            part.wanted = std::max(part.wanted, wanted_[t]);
            ++part.num_triangles;
            for (std::size_t k = 0; k < 3; ++k) {
                const Index next = inside(t, k);
                if (next != kInvalidIndex && groups_.find(next) == own) continue;
                part.border += side(t, k);
                if (next != kInvalidIndex)
                    part.neighbors.emplace_back(groups_.find(next), side(t, k));
            }
        }
        for (Part& part : parts_) join_neighbors(part);
    }

    // One entry per neighbour, in ascending order, by their names now.
    void join_neighbors(Part& part) {
        for (auto& [name, shared] : part.neighbors) name = groups_.find(name);
        std::ranges::stable_sort(part.neighbors, {}, &std::pair<Index, double>::first);
        std::size_t kept = 0;
        for (const auto& [name, shared] : part.neighbors) {
            if (kept > 0 && part.neighbors[kept - 1].first == name)
                part.neighbors[kept - 1].second += shared;
            else
                part.neighbors[kept++] = {name, shared};
        }
        part.neighbors.resize(kept);
    }

    Part united(const Part& a, const Part& b, double shared) const {
        Part out;
        out.area = a.area + b.area;
        out.border = std::max(0.0, a.border + b.border - 2.0 * shared);
        out.wanted = std::max(a.wanted, b.wanted);
        out.num_triangles = a.num_triangles + b.num_triangles;
        return out;
    }

    void offer_all(Index p) {
        for (const auto& [other, shared] : parts_[p].neighbors) {
            const auto [a, b] = std::minmax(p, other);
            const double saving = parts_[a].cost(gutter_) + parts_[b].cost(gutter_) -
                                  united(parts_[a], parts_[b], shared).cost(gutter_);
            if (saving > 0.0) offers_.push({saving, a, b, parts_[a].version, parts_[b].version});
        }
    }

    void merge(Index a, Index b) {
        Part& to = parts_[a];
        Part& from = parts_[b];
        const auto shared = std::ranges::find(to.neighbors, b, &std::pair<Index, double>::first);
        Part sum = united(to, from, shared->second);
        sum.version = to.version + 1;
        sum.neighbors = std::move(to.neighbors);
        sum.neighbors.insert(sum.neighbors.end(), from.neighbors.begin(), from.neighbors.end());
        from = {};
        from.version = -1;
        groups_.unite(a, b);
        join_neighbors(sum);
        std::erase_if(sum.neighbors, [&](const auto& n) { return n.first == a; });
        to = std::move(sum);
        // The neighbours' lists still name b; its shares are joined when they are looked at.
        for (const auto& [name, length] : to.neighbors) join_neighbors(parts_[name]);
        offer_all(a);
    }

    void number_charts() {
        std::vector<Index> number(wanted_.size(), kInvalidIndex);
        charts_.count = 0;
        for (Index t = 0; t < wanted_.size(); ++t) {
            Index& n = number[groups_.find(t)];
            if (n == kInvalidIndex) n = charts_.count++;
            charts_.of_triangle[t] = n;
        }
    }

    Charts& charts_;
    std::span<const double> wanted_;
    double gutter_;
    std::span<const std::array<Index, 3>> neighbors_;
    UnionFind groups_;  // triangles of a part; named by its lowest
    std::vector<Part> parts_;
    std::priority_queue<Offer> offers_;
};

}  // namespace

double chart_gutter(double area, double border, double density, double gutter) {
    constexpr double kLeast = 1.0;
    if (!(border > 0.0)) return gutter;
    return std::clamp(density * area / border, kLeast, std::max(kLeast, gutter));
}

double chart_texels(double area, double border, double density, double gutter) {
    const double g = chart_gutter(area, border, density, gutter);
    return area * density * density + border * density * g + 3.15 * g * g;
}

void split_by_density_in_place(Charts& charts, std::span<const double> wanted, double gutter,
                               std::span<const std::array<Index, 3>> neighbors) {
    Splitter(charts, wanted, gutter, neighbors).run();
}

}  // namespace pointbake
