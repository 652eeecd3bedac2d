// Rounds, each of which may double the spacing where quadrics through the neighbours fit.
#include "reconstruct/thin_smooth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>

#include "core/kdtree.h"
#include "core/local_quadric.h"
#include "core/parallel.h"
#include "reconstruct/rivals.h"

namespace pointbake {
namespace {

constexpr double kPi = 3.141592653589793;
constexpr int kRounds = 3;
constexpr std::size_t kNeighbors = 24;  // besides the point: a disc of 2.8 spacings
constexpr std::size_t kFewestPoints = 2 * kNeighbors;
// Farthest that points are told to keep apart, of the disc's radius: two spacings.
constexpr double kMostReach = 0.72;
// How much farther points may be apart than their neighbours, per length between them.
constexpr double kGradation = 0.5;
// Deviation from the quadric, of the tolerance.
constexpr double kMostDeviation = 0.5;
// Of the neighbours' mean from the point, of the disc's radius: 0.42 on a straight border, 0.1
// scatters.
constexpr double kMostOffCentre = 0.3;
// Balls on both sides of the surface, in new spacings, that no other sheet may enter: it is twice
// as far away then. How deep the surface itself may enter, of the radius.
constexpr double kBallRadius = 2.0, kDeepest = 0.05;
// A round that keeps more than this share was the last one.
constexpr double kLastRound = 0.8;
constexpr std::size_t kGrain = 256;

/// What is left after a round, with what later rounds need to know.
struct Subset {
    std::vector<Index> ids;
    std::vector<Vec3d> points;
    std::vector<std::uint8_t> may_thin;  // whether a wider look is of use
    // Empty before the first round:
    std::vector<float> tolerance;  // a length
    std::vector<float> apart;      // how far points are or may be from each other
};

class Round {
 public:
    Round(const Subset& in, double tolerance, double most_length, const Context& context)
        : in_(in),
          tolerance_(tolerance),
          most_length_(most_length),
          context_(context),
          tree_(std::in_place, in.points) {}

    Subset run() {
        find_reach();
        keep_rivals();
        return subset(
            choose_among_rivals(in_.points, [&](Index i) { return rivals_of(i); }, context_));
    }

 private:
    using Buffer = std::array<Neighbor, kNeighbors + 1>;

    struct Look {
        float spacing = 0.0F;  // of the square that each neighbour has; 0 = not looked at
        float reach = 0.0F;    // how far apart points may be; 0 = as they are
        float radius = 0.0F;
    };

    void find_reach() {
        const std::size_t n = in_.points.size();
        looks_.resize(n);
        neighbors_.resize(n * kNeighbors);
        lengths_ = in_.tolerance;
        lengths_.resize(n);
        parallel_for(context_, n, kGrain, [&](std::size_t begin, std::size_t end) {
            Buffer buffer;
            for (std::size_t i = begin; i < end; ++i)
                if (in_.may_thin[i] != 0) look(i, tree_->nearest(in_.points[i], buffer));
        });
        tree_.reset();
        reach_.resize(n);
        parallel_for(context_, n, kGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                reach_[i] = looks_[i].reach > 0.0F ? graded_reach(static_cast<Index>(i)) : 0.0;
        });
    }

    void look(std::size_t i, std::span<const Neighbor> found) {
        const double radius2 = found.back().squared_distance;
        Look& look = looks_[i];
        look.radius = static_cast<float>(std::sqrt(radius2));
        look.spacing = static_cast<float>(std::sqrt(kPi * radius2 / kNeighbors));
        if (in_.tolerance.empty())
            lengths_[i] = static_cast<float>(
                std::min(tolerance_ * static_cast<double>(look.spacing), most_length_));
        auto* out = &neighbors_[i * kNeighbors];
        for (const Neighbor& n : found.last(kNeighbors)) *out++ = n.index;
        const double reach = reach_at(in_.points[i], static_cast<double>(lengths_[i]), found);
        look.reach = reach > static_cast<double>(look.spacing) ? static_cast<float>(reach) : 0.0F;
    }

    // 0 where the points do not tell.
    double reach_at(Vec3d p, double tolerance, std::span<const Neighbor> found) const {
        const double radius = std::sqrt(found.back().squared_distance);
        Vec3d mean;
        for (const Neighbor& n : found) mean += in_.points[n.index] - p;
        if (length(mean) > kMostOffCentre * radius * static_cast<double>(found.size())) return 0.0;
        const auto frame = tangent_frame(in_.points, p, found);
        if (!frame) return 0.0;
        QuadricFit fit(*frame, radius);
        for (const Neighbor& n : found) fit.add(in_.points[n.index]);
        const auto quadric = fit.solve();
        if (!quadric || !(std::sqrt(quadric->variance) <= kMostDeviation * tolerance)) return 0.0;
        const auto& c = quadric->c;
        const double curvature =
            std::abs(c[3] + c[5]) + std::sqrt((c[3] - c[5]) * (c[3] - c[5]) + c[4] * c[4]);
        double reach = kMostReach * radius;
        if (curvature * reach * reach > 2.0 * tolerance)
            reach = std::sqrt(2.0 * tolerance / curvature);
        const Vec3d slope = frame->normal - frame->u * c[1] - frame->v * c[2];
        return is_alone(p, normalized(slope), reach) ? reach : 0.0;
    }

    // No other sheet is near.
    bool is_alone(Vec3d p, Vec3d normal, double reach) const {
        const double radius = kBallRadius * reach, inner = (1.0 - kDeepest) * radius;
        return !tree_->has_within(p + normal * radius, inner * inner) &&
               !tree_->has_within(p - normal * radius, inner * inner);
    }

    float apart(std::size_t i) const {
        return in_.may_thin[i] != 0 ? std::max(looks_[i].reach, looks_[i].spacing) : in_.apart[i];
    }

    // Of a point that the surface lets be thinned, growing slowly.
    double graded_reach(Index i) const {
        double reach = static_cast<double>(looks_[i].reach);
        for (Index j : neighbors_of(i)) {
            reach = std::min(reach, static_cast<double>(apart(j)) +
                                        kGradation * length(in_.points[i] - in_.points[j]));
        }
        return reach;
    }

    // Of each point's neighbours, those it cannot stay beside, at the front of its row.
    void keep_rivals() {
        num_rivals_.assign(in_.points.size(), 0);
        parallel_for(context_, in_.points.size(), kGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                if (reach_[i] == 0.0) continue;
                const auto row = std::span(neighbors_).subspan(i * kNeighbors, kNeighbors);
                const auto last = std::remove_if(row.begin(), row.end(), [&](Index j) {
                    const double reach = std::min(reach_[i], reach_[j]);
                    return squared_length(in_.points[i] - in_.points[j]) >= reach * reach;
                });
                num_rivals_[i] = static_cast<std::uint8_t>(last - row.begin());
            }
        });
    }

    std::span<const Index> rivals_of(Index i) const {
        return neighbors_of(i).first(num_rivals_[i]);
    }

    // Until their rows are taken for the rivals.
    std::span<const Index> neighbors_of(Index i) const {
        return std::span(neighbors_).subspan(std::size_t{i} * kNeighbors, kNeighbors);
    }

    Subset subset(const std::vector<std::uint8_t>& is_kept) const {
        Subset out;
        for (Index i = 0; i < is_kept.size(); ++i) {
            if (is_kept[i] == 0) continue;
            const Look& look = looks_[i];
            out.ids.push_back(in_.ids[i]);
            out.points.push_back(in_.points[i]);
            out.tolerance.push_back(lengths_[i]);
            out.apart.push_back(apart(i));
            out.may_thin.push_back(look.reach >
                                   0.95F * static_cast<float>(kMostReach) * look.radius);
        }
        return out;
    }

    const Subset& in_;
    double tolerance_, most_length_;
    const Context& context_;
    std::optional<KdTree> tree_;  // until the neighbours are known
    std::vector<Look> looks_;
    std::vector<Index> neighbors_;
    std::vector<float> lengths_;
    std::vector<double> reach_;
    std::vector<std::uint8_t> num_rivals_;
};

}  // namespace

std::vector<Index> thin_smooth(std::vector<Vec3d> points, double tolerance, double most_length,
                               const Context& context) {
    Subset subset;
    subset.ids.resize(points.size());
    std::iota(subset.ids.begin(), subset.ids.end(), Index{0});
    subset.may_thin.assign(points.size(), 1);
    subset.points = std::move(points);
    for (int round = 0; round < kRounds && subset.ids.size() >= kFewestPoints; ++round) {
        const auto before = static_cast<double>(subset.ids.size());
        subset = Round(subset, tolerance, most_length, context).run();
        if (static_cast<double>(subset.ids.size()) > kLastRound * before) break;
    }
    return std::move(subset.ids);
}

}  // namespace pointbake
