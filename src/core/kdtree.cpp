// A k-d tree by nanoflann [Blanco14]. It departs from nanoflann's own search in the order of ties:
// there, of two points at the same distance the one met first stays, which depends on the shape of
// the tree; here the lower index stays.
#include "core/kdtree.h"

#include <limits>
#include <nanoflann.hpp>

namespace pointbake {
namespace {

// Points per leaf. For 16 neighbours on scans, anything from 10 to 32 takes the same time.
constexpr std::size_t kLeafSize = 16;

// The tree adds up its lower bounds in another order than a distance is added up. They may lie
// above the distance by some units in the last place; the search reaches that much farther.
constexpr double kBoundSlack = 1.0 + 1e-12;

struct Points {
    std::span<const Vec3d> positions;

    std::size_t kdtree_get_point_count() const { return positions.size(); }
    double kdtree_get_pt(Index i, std::size_t axis) const { return positions[i][axis]; }
    template <class Bounds>
    bool kdtree_get_bbox(Bounds&) const {
        return false;
    }
};

bool is_closer(const Neighbor& a, const Neighbor& b) {
    return a.squared_distance < b.squared_distance ||
           (a.squared_distance == b.squared_distance && a.index < b.index);
}

/// What nanoflann calls a result set: the nearest points so far, in order.
class NearestSet {
 public:
    explicit NearestSet(std::span<Neighbor> items) : items_(items) {}

    std::size_t size() const { return count_; }
    bool full() const { return count_ == items_.size(); }
    double worstDist() const { return bound_; }

    bool addPoint(double squared_distance, Index index) {
        const Neighbor candidate{index, squared_distance};
        if (full() && !is_closer(candidate, items_[count_ - 1])) return true;
        if (!full()) ++count_;
        std::size_t i = count_ - 1;
        for (; i > 0 && is_closer(candidate, items_[i - 1]); --i) items_[i] = items_[i - 1];
        items_[i] = candidate;
        // nanoflann asks for less than the bound: the smallest normal number lets ties at 0 in.
        if (full())
            bound_ = items_[count_ - 1].squared_distance * kBoundSlack +
                     std::numeric_limits<double>::min();
        return true;
    }

 private:
    std::span<Neighbor> items_;
    std::size_t count_ = 0;
    double bound_ = std::numeric_limits<double>::infinity();
};

/// Any other point than one's own within a distance.
class AnyOther {
 public:
    AnyOther(Index own, double squared_distance) : own_(own), bound_(squared_distance) {}

    std::size_t size() const { return is_found_ ? 1 : 0; }
    bool full() const { return true; }
    double worstDist() const { return bound_; }
    bool is_found() const { return is_found_; }

    // nanoflann goes on where this is true.
    bool addPoint(double, Index index) {
        is_found_ = is_found_ || index != own_;
        return !is_found_;
    }

 private:
    Index own_;
    double bound_;
    bool is_found_ = false;
};

using Tree =
    nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Points, double, Index>,
                                        Points, 3, Index>;

}  // namespace

struct KdTree::Impl {
    Points points;
    Tree tree;

    explicit Impl(std::span<const Vec3d> positions)
        : points{positions},
          tree(3, points, nanoflann::KDTreeSingleIndexAdaptorParams(kLeafSize)) {}

    bool has_other(Vec3d p, Index own, double squared_distance) const {
        AnyOther found(own, squared_distance * kBoundSlack + std::numeric_limits<double>::min());
        const double coordinates[3] = {p.x, p.y, p.z};
        tree.findNeighbors(found, coordinates, nanoflann::SearchParams());
        return found.is_found();
    }
};

KdTree::KdTree(std::span<const Vec3d> positions) : impl_(std::make_unique<Impl>(positions)) {}
KdTree::~KdTree() = default;
KdTree::KdTree(KdTree&&) noexcept = default;

std::span<Neighbor> KdTree::nearest(Vec3d query, std::span<Neighbor> out) const {
    if (out.empty() || impl_->points.positions.empty()) return out.first(0);
    NearestSet found(out);
    const double coordinates[3] = {query.x, query.y, query.z};
    impl_->tree.findNeighbors(found, coordinates, nanoflann::SearchParams());
    return out.first(found.size());
}

bool KdTree::has_nearer(Index point, double squared_distance) const {
    return impl_->has_other(impl_->points.positions[point], point, squared_distance);
}

bool KdTree::has_within(Vec3d place, double squared_distance) const {
    return impl_->has_other(place, kInvalidIndex, squared_distance);
}

}  // namespace pointbake
