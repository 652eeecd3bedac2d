#include "reconstruct/thin.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "core/kdtree.h"
#include "core/parallel.h"
#include "reconstruct/rivals.h"
#include "reconstruct/tetrahedra.h"
#include "reconstruct/thin_smooth.h"

namespace pointbake {
namespace {

constexpr double kPi = 3.141592653589793;
constexpr std::size_t kNeighbors = 12;  // all that is nearer than 1.9 spacings is among them
constexpr std::size_t kGrain = 1024;

class Thinner {
 public:
    Thinner(std::span<const Vec3d> points, double share, const Context& context)
        : points_(points), share_(share), context_(context), tree_(points) {}

    std::vector<Index> run() {
        find_reach();
        gather_rivals();
        const std::vector<std::uint8_t> is_kept =
            choose_among_rivals(points_, [&](Index i) { return rivals_of(i); }, context_);
        std::vector<Index> kept;
        for (Index i = 0; i < is_kept.size(); ++i)
            if (is_kept[i] != 0) kept.push_back(i);
        return kept;
    }

 private:
    using Buffer = std::array<Neighbor, kNeighbors + 1>;  // the point itself is among them

    // 0 for a point with no other one as near: most have none, and a look at the points next to
    // them in order, which are no nearer than the nearest ones, tells.
    void find_reach() {
        reach2_.assign(points_.size(), 0.0);
        may_have_rivals_.assign(points_.size(), 0);
        parallel_for(context_, points_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
            Buffer buffer;
            for (std::size_t i = begin; i < end; ++i) {
                if (!tree_.has_nearer(static_cast<Index>(i), largest_reach2(i))) continue;
                const auto found = tree_.nearest(points_[i], buffer);
                const double density =
                    static_cast<double>(std::max<std::size_t>(found.size(), 2) - 1);
                reach2_[i] = share_ * share_ * kPi * found.back().squared_distance / density;
                // The first one is the point, or one in the same place.
                may_have_rivals_[i] =
                    found.size() > 1 && found[1].squared_distance < reach2_[i] ? 1 : 0;
            }
        });
    }

    // The farthest of as many points as are looked at is no nearer than that of the nearest ones.
    double largest_reach2(std::size_t point) const {
        if (points_.size() <= kNeighbors) return HUGE_VAL;
        const std::size_t begin =
            std::min(point - std::min(point, kNeighbors / 2), points_.size() - kNeighbors - 1);
        double farthest2 = 0.0;
        for (std::size_t k = begin; k <= begin + kNeighbors; ++k)
            farthest2 = std::max(farthest2, squared_length(points_[k] - points_[point]));
        constexpr double kSlack = 1.0 + 1e-9;  // for the rounding
        return kSlack * share_ * share_ * kPi * farthest2 / static_cast<double>(kNeighbors);
    }

    void gather_rivals() {
        begin_.assign(points_.size() + 1, 0);
        std::vector<std::vector<Index>> found_in((points_.size() + kGrain - 1) / kGrain);
        parallel_for(context_, points_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
            std::vector<Index>& found = found_in[begin / kGrain];
            for (std::size_t i = begin; i < end; ++i) {
                const std::size_t before = found.size();
                append_rivals(static_cast<Index>(i), found);
                begin_[i + 1] = found.size() - before;
            }
        });
        std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
        rivals_.reserve(begin_.back());
        for (const auto& part : found_in) rivals_.insert(rivals_.end(), part.begin(), part.end());
    }

    std::span<const Index> rivals_of(Index point) const {
        return std::span(rivals_).subspan(begin_[point], begin_[point + 1] - begin_[point]);
    }

    // Few points have any.
    void append_rivals(Index i, std::vector<Index>& list) const {
        if (may_have_rivals_[i] == 0) return;
        Buffer buffer;
        for (const Neighbor& n : tree_.nearest(points_[i], buffer))
            if (n.index != i && n.squared_distance < std::min(reach2_[i], reach2_[n.index]))
                list.push_back(n.index);
    }

    std::span<const Vec3d> points_;
    double share_;
    const Context& context_;
    KdTree tree_;
    std::vector<double> reach2_;
    std::vector<std::uint8_t> may_have_rivals_;
    std::vector<std::size_t> begin_;  // of each point's rivals
    std::vector<Index> rivals_;
};

}  // namespace

std::vector<Index> thin(std::span<const Vec3d> points, ThinRule rule, const Context& context) {
    // Searches one after the other walk through the same part of the tree.
    const std::vector<Index> order = order_by_place(points, context);
    std::vector<Vec3d> sorted(points.size());
    for (std::size_t i = 0; i < sorted.size(); ++i) sorted[i] = points[order[i]];
    std::vector<Index> kept = Thinner(sorted, rule.nearest, context).run();
    if (rule.tolerance > 0.0) {
        for (std::size_t k = 0; k < kept.size(); ++k) sorted[k] = sorted[kept[k]];
        sorted.resize(kept.size());
        std::vector<Index> enough =
            thin_smooth(std::move(sorted), rule.tolerance, rule.most_length, context);
        for (Index& i : enough) i = kept[i];
        kept = std::move(enough);
    }
    for (Index& i : kept) i = order[i];
    std::sort(kept.begin(), kept.end());
    return kept;
}

}  // namespace pointbake
