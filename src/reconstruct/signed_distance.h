// The signed distance to the surface that oriented, noisy points sample.
#pragma once

#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "pointbake/context.h"
#include "pointbake/types.h"

namespace pointbake {

/// What the points near a place say about it. Lengths in cloud units.
struct FieldSample {
    float value = 0.0F;     ///< signed distance to the surface, positive outside
    float spacing = 0.0F;   ///< local spacing of the points
    float density = 0.0F;   ///< of points around the foot point: about 1 inside a sampled surface,
                            ///< 1/2 at a straight border; the same along the normal
    Vec3f normal;           ///< unit, gradient of the value
    bool is_known = false;  ///< false where no point is near: the rest then means nothing
    bool is_bent = false;   ///< near a crease or another sheet: the normals around disagree
};

/// Immutable; queries are thread-safe and depend on the set of points alone, not on their order.
class SignedDistance {
 public:
    /// Points are finite and distinct; those with a zero normal or without a positive spacing are
    /// left out. `noise` is its standard deviation along the normal, in local spacings. O(n log n).
    SignedDistance(std::span<const Vec3d> points, std::span<const Vec3f> normals,
                   std::span<const float> spacing, double noise, const Context& context);

    /// At each place; fastest where places are near each other. O(log n + points within reach)
    /// each; about 70 are, without noise.
    std::vector<FieldSample> at(std::span<const Vec3d> places, const Context& context) const;
    /// Whether a point lies within the radius, of those that do not reach farther than
    /// `most_reach`. O(log n) where one does or none is near.
    bool has_point_within(Vec3d place, double radius, double most_reach = HUGE_VAL) const;

    std::size_t size() const { return num_points_; }
    double noise() const { return noise_; }
    const Box& box() const { return box_; }
    float min_spacing() const { return min_spacing_; }
    float median_spacing() const { return median_spacing_; }

 private:
    struct Point {
        Vec3d position;
        Vec3f normal;
        float spacing;
    };
    /// Points that are near each other, as arrays: sums over them run in lanes.
    struct Leaf {
        static constexpr std::size_t kSize = 8;
        using Values = std::array<float, kSize>;
        Vec3d center;  ///< of their box; positions are relative to it
        Vec3f half;    ///< of the box's extent
        float reach;   ///< the largest of theirs
        Vec3<Values> position, normal;
        Values fineness;  ///< points per area: where spacings differ, fine ones count more; 0 where
                          ///< the leaf is not full
    };
    struct Node {
        Box box;                   ///< around the points
        float reach = 0.0F;        ///< the largest of theirs
        float least_reach = 0.0F;  ///< the smallest of theirs
    };
    struct Near {
        const Leaf* leaf;
        Vec3f place;            ///< relative to the leaf
        Leaf::Values fineness;  ///< 0 for points that do not reach the place
    };
    struct Start {
        Vec3f normal;               ///< of no length yet, may be 0
        float distance2, fineness;  ///< of the nearest point
    };
    struct Fit;
    class Cursor;

    void sort_in_place(std::vector<Point>& points, const Context& context) const;
    void build_tree(std::span<const Point> points, const Context& context);
    Leaf make_leaf(std::span<const Point> points, const Node& node) const;
    Node make_node(std::span<const Point> points) const;
    template <class IsNear, class Visit>
    void visit(IsNear&& is_near, Visit&& visit_leaf) const;
    template <class Visit>
    static void for_each(std::span<const Near> near, Visit&& visit_lanes);
    Start start(std::span<const Near> near) const;
    bool is_overreached(Vec3d place, const Start& start) const;
    FieldSample describe(Vec3d place, std::span<const Near> near) const;
    Fit first_fit(std::span<const Near> near, Vec3f normal) const;
    Fit nearest_fit(std::span<const Near> near) const;
    Fit refine(std::span<const Near> near, const Fit& fit) const;
    FieldSample describe(std::span<const Near> near, const Fit& fit) const;

    std::vector<Leaf> leaves_;  ///< in Morton order
    std::vector<Node> nodes_;   ///< a complete binary tree: children of k at 2k + 1 and 2k + 2
    std::size_t num_points_ = 0;
    std::size_t num_leaves_ = 0;  ///< of the tree: from leaves_.size() on they are empty
    Box box_;
    double noise_ = 0.0;
    double cells_per_unit_ = 1.0;  ///< of the grid behind the Morton codes
    float min_spacing_ = 0.0F, median_spacing_ = 0.0F;
    float width_ = 0.0F;  ///< radius of the kernel of the fit, in spacings
    float reach_ = 0.0F;  ///< how far away a point is taken in, in spacings
};

}  // namespace pointbake
