#include "texture/chart_density.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "core/parallel.h"
#include "core/union_find.h"

namespace pointbake {
namespace {

// Texels that one more chart must save: the block of 32 x 32 that mip levels from afar see of it.
constexpr double kPriceOfChart = 1024.0;
constexpr int kMostRounds = 64;

struct Part {
    double area = 0.0, border = 0.0, wanted = 0.0;
    std::size_t num_triangles = 0;

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

Part united(const Part& a, const Part& b, double shared) {
    return {a.area + b.area, std::max(0.0, a.border + b.border - 2.0 * shared),
            std::max(a.wanted, b.wanted), a.num_triangles + b.num_triangles};
}

// Two parts side by side.
struct Pair {
    Index a, b;  // a < b
    double shared = 0.0, saving = 0.0;
};

class Splitter {
 public:
    Splitter(Charts& charts, std::span<const double> wanted, double gutter,
             std::span<const std::array<Index, 3>> neighbors)
        : charts_(charts),
          wanted_(wanted),
          gutter_(gutter),
          neighbors_(neighbors),
          groups_(wanted.size()) {}

    void run(const Context& context) {
        for (int round = 0; round < kMostRounds; ++round) {
            check_cancelled(context);
            measure_parts();
            if (!merge_best_first(pairs_that_save())) break;
        }
        number_charts();
    }

 private:
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

    void measure_parts() {
        parts_.assign(wanted_.size(), {});
        for (Index t = 0; t < wanted_.size(); ++t) {
            const Index own = groups_.find(t);
            Part& part = parts_[own];
            const std::array<Vec2d, 3>& x = charts_.corners[t];
            part.area += 0.5 * std::fabs(cross(x[1] - x[0], x[2] - x[0]));
            part.wanted = std::max(part.wanted, wanted_[t]);
            ++part.num_triangles;
            for (std::size_t k = 0; k < 3; ++k) {
                const Index next = inside(t, k);
                if (next == kInvalidIndex || groups_.find(next) != own) part.border += side(t, k);
            }
        }
    }

    std::vector<Pair> pairs_that_save() {
        std::vector<Pair> sides;
        for (Index t = 0; t < wanted_.size(); ++t)
            for (std::size_t k = 0; k < 3; ++k) {
                const Index next = inside(t, k);
                if (next == kInvalidIndex || next < t) continue;
                const auto [a, b] = std::minmax({groups_.find(t), groups_.find(next)});
                if (a != b) sides.push_back({a, b, side(t, k)});
            }
        const auto names = [](const Pair& p) { return std::pair(p.a, p.b); };
        std::ranges::stable_sort(sides, {}, names);
        std::vector<Pair> pairs;
        for (const Pair& p : sides) {
            if (pairs.empty() || names(pairs.back()) != names(p))
                pairs.push_back(p);
            else
                pairs.back().shared += p.shared;
        }
        for (Pair& p : pairs) p.saving = saving(p.a, p.b, p.shared);
        std::erase_if(pairs, [](const Pair& p) { return !(p.saving > 0.0); });
        std::ranges::sort(pairs, [](const Pair& p, const Pair& q) {
            return std::tie(q.saving, p.a, p.b) < std::tie(p.saving, q.a, q.b);
        });
        return pairs;
    }

    double saving(Index a, Index b, double shared) const {
        return parts_[a].cost(gutter_) + parts_[b].cost(gutter_) -
               united(parts_[a], parts_[b], shared).cost(gutter_);
    }

    // What has grown since the pairs were made is looked at as it is now, but for sides that it
    // came to share with others: the next round knows those.
    bool merge_best_first(const std::vector<Pair>& pairs) {
        bool has_merged = false;
        for (const Pair& p : pairs) {
            const Index a = groups_.find(p.a), b = groups_.find(p.b);
            if (a == b || !(saving(a, b, p.shared) > 0.0)) continue;
            const Part sum = united(parts_[a], parts_[b], p.shared);
            groups_.unite(a, b);
            parts_[groups_.find(a)] = sum;
            has_merged = true;
        }
        return has_merged;
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
    UnionFind groups_;         // triangles of a part
    std::vector<Part> parts_;  // by the name of their group
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
                               std::span<const std::array<Index, 3>> neighbors,
                               const Context& context) {
    Splitter(charts, wanted, gutter, neighbors).run(context);
}

}  // namespace pointbake
