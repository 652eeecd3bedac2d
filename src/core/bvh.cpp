// A binary bounding volume hierarchy, split by the binned surface area heuristic [Wald07].
// Closest points after [Ericson05] 5.1.5; rays by the watertight test of [Woop13], in double.
#include "core/bvh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

namespace pointbake {
namespace {

constexpr Index kLeafSize = 4;
constexpr int kNumBins = 8;
// Deeper than this only halving by rank is allowed, so that depth stays below kStackSize for any
// input: at most 32 more levels follow.
constexpr int kMaxBinnedDepth = 48;
constexpr std::size_t kStackSize = 96;
// A box test may be off by a few ulps against the exact triangle test; growing the far end of the
// slab by this keeps it conservative.
constexpr double kSlabGrowth = 1.0 + 0x1.0p-48;

// One step more than rounding to nearest needs: the box also covers errors of the double arithmetic
// of queries.
float float_below(double v) {
    return std::nextafter(static_cast<float>(v), -std::numeric_limits<float>::infinity());
}
float float_above(double v) {
    return std::nextafter(static_cast<float>(v), std::numeric_limits<float>::infinity());
}

struct FloatBox {
    Vec3f low{HUGE_VALF, HUGE_VALF, HUGE_VALF};
    Vec3f high{-HUGE_VALF, -HUGE_VALF, -HUGE_VALF};

    void extend(const FloatBox& b) {
        low = {std::min(low.x, b.low.x), std::min(low.y, b.low.y), std::min(low.z, b.low.z)};
        high = {std::max(high.x, b.high.x), std::max(high.y, b.high.y), std::max(high.z, b.high.z)};
    }
    float center(std::size_t axis) const { return 0.5F * low[axis] + 0.5F * high[axis]; }
    float half_area() const {
        const Vec3f e = high - low;
        return e.x < 0.0F ? 0.0F : e.x * e.y + e.y * e.z + e.z * e.x;
    }
};

// Squared distance of p to the box; 0 inside.
double squared_distance_to_box(Vec3d p, Vec3f low, Vec3f high) {
    const double dx = std::max({low.x - p.x, 0.0, p.x - high.x});
    const double dy = std::max({low.y - p.y, 0.0, p.y - high.y});
    const double dz = std::max({low.z - p.z, 0.0, p.z - high.z});
    return dx * dx + dy * dy + dz * dz;
}

struct StackEntry {
    Index node;
    double key;
};

// Barycentrics of the point of the segment from corner i to corner j that is closest to p, where
// `corners` are relative to p.
Vec3d closest_on_edge(const std::array<Vec3d, 3>& corners, std::size_t i, std::size_t j) {
    const Vec3d e = corners[j] - corners[i];
    const double ee = squared_length(e);
    const double t = ee > 0.0 ? std::clamp(-dot(corners[i], e) / ee, 0.0, 1.0) : 0.0;
    Vec3d bary;
    bary[i] = 1.0 - t;
    bary[j] = t;
    return bary;
}

Vec3d at(const std::array<Vec3d, 3>& corners, Vec3d bary) {
    return corners[0] * bary.x + corners[1] * bary.y + corners[2] * bary.z;
}

Vec3d closest_on_edges(const std::array<Vec3d, 3>& corners) {
    Vec3d best = closest_on_edge(corners, 0, 1);
    for (std::size_t k = 1; k < 3; ++k) {
        const Vec3d other = closest_on_edge(corners, k, (k + 1) % 3);
        if (squared_length(at(corners, other)) < squared_length(at(corners, best))) best = other;
    }
    return best;
}

// Barycentrics of the point of the triangle that is closest to the origin.
Vec3d closest_barycentric(const std::array<Vec3d, 3>& corners) {
    const auto& [a, b, c] = corners;
    const Vec3d ab = b - a, ac = c - a;
    const double d1 = -dot(ab, a), d2 = -dot(ac, a);
    if (d1 <= 0.0 && d2 <= 0.0 && squared_length(ab) > 0.0 && squared_length(ac) > 0.0)
        return {1.0, 0.0, 0.0};
    const double d3 = -dot(ab, b), d4 = -dot(ac, b);
    const double d5 = -dot(ab, c), d6 = -dot(ac, c);
    const double wa = d3 * d6 - d5 * d4, wb = d5 * d2 - d1 * d6, wc = d1 * d4 - d3 * d2;
    const double sum = wa + wb + wc;
    if (wa > 0.0 && wb > 0.0 && wc > 0.0 && sum > 0.0) {
        const double v = wb / sum, w = wc / sum;
        return {1.0 - v - w, v, w};
    }
    return closest_on_edges(corners);
}

}  // namespace

ClosestPoint closest_point_on_triangle(Vec3d p, Vec3d a, Vec3d b, Vec3d c) {
    const std::array<Vec3d, 3> corners{a - p, b - p, c - p};
    const Vec3d bary = closest_barycentric(corners);
    const Vec3d offset = at(corners, bary);
    return {kInvalidIndex, p + offset, bary, squared_length(offset)};
}

class BvhBuilder {
 public:
    explicit BvhBuilder(TriangleBvh& bvh) : bvh_(bvh), boxes_(bvh.triangles_.size()) {
        for (std::size_t t = 0; t < boxes_.size(); ++t) {
            Box box;
            for (Index v : bvh.triangles_[t]) box.extend(bvh.positions_[v] - bvh.origin_);
            boxes_[t].low = {float_below(box.low.x), float_below(box.low.y),
                             float_below(box.low.z)};
            boxes_[t].high = {float_above(box.high.x), float_above(box.high.y),
                              float_above(box.high.z)};
        }
    }

    // Adds the subtree over order_[begin, end); left children follow their parents.
    void build(Index begin, Index end, int depth) {
        const Index node = static_cast<Index>(bvh_.nodes_.size());
        FloatBox box;
        for (Index i = begin; i < end; ++i) box.extend(boxes_[bvh_.order_[i]]);
        bvh_.nodes_.push_back({box.low, box.high, begin, end - begin});
        if (end - begin <= kLeafSize) return;
        Index middle = depth < kMaxBinnedDepth ? split_by_bins(begin, end) : begin;
        if (middle == begin || middle == end) middle = split_by_rank(begin, end, box);
        build(begin, middle, depth + 1);
        bvh_.nodes_[node].first = static_cast<Index>(bvh_.nodes_.size());
        bvh_.nodes_[node].count = 0;
        build(middle, end, depth + 1);
    }

 private:
    struct Bin {
        FloatBox box;
        Index count = 0;
    };

    // Partitions at the cheapest of the planes between bins along the widest axis of the centres;
    // returns begin or end if there is none.
    Index split_by_bins(Index begin, Index end) {
        float low[3] = {HUGE_VALF, HUGE_VALF, HUGE_VALF};
        float high[3] = {-HUGE_VALF, -HUGE_VALF, -HUGE_VALF};
        for (Index i = begin; i < end; ++i) {
            for (std::size_t k = 0; k < 3; ++k) {
                const float c = boxes_[bvh_.order_[i]].center(k);
                low[k] = std::min(low[k], c), high[k] = std::max(high[k], c);
            }
        }
        std::size_t axis = 0;
        for (std::size_t k = 1; k < 3; ++k) {
            if (high[k] - low[k] > high[axis] - low[axis]) axis = k;
        }
        const float width = high[axis] - low[axis];
        if (!(width > 0.0F)) return begin;
        const float scale = static_cast<float>(kNumBins) / width;
        const auto bin_of = [&](Index t) {
            const float b = (boxes_[t].center(axis) - low[axis]) * scale;
            return std::min(static_cast<int>(b), kNumBins - 1);
        };
        std::array<Bin, kNumBins> bins;
        for (Index i = begin; i < end; ++i) {
            Bin& bin = bins[static_cast<std::size_t>(bin_of(bvh_.order_[i]))];
            bin.box.extend(boxes_[bvh_.order_[i]]);
            ++bin.count;
        }
        const int cut = cheapest_cut(bins);
        const auto first = bvh_.order_.begin();
        return static_cast<Index>(
            std::partition(first + begin, first + end, [&](Index t) { return bin_of(t) < cut; }) -
            first);
    }

    static int cheapest_cut(const std::array<Bin, kNumBins>& bins) {
        std::array<float, kNumBins> cost{};
        FloatBox box;
        Index count = 0;
        for (std::size_t b = 0; b + 1 < kNumBins; ++b) {
            box.extend(bins[b].box);
            count += bins[b].count;
            cost[b + 1] = box.half_area() * static_cast<float>(count);
        }
        box = {}, count = 0;
        std::size_t best = 0;
        float best_cost = HUGE_VALF;
        for (std::size_t b = kNumBins - 1; b > 0; --b) {
            box.extend(bins[b].box);
            count += bins[b].count;
            const float total = cost[b] + box.half_area() * static_cast<float>(count);
            if (total <= best_cost) best_cost = total, best = b;
        }
        return static_cast<int>(best);
    }

    Index split_by_rank(Index begin, Index end, const FloatBox& box) {
        const Vec3f e = box.high - box.low;
        const std::size_t axis = e.x >= e.y && e.x >= e.z ? 0 : (e.y >= e.z ? 1 : 2);
        const Index middle = begin + (end - begin) / 2;
        const auto first = bvh_.order_.begin();
        std::nth_element(first + begin, first + middle, first + end, [&](Index s, Index t) {
            const float cs = boxes_[s].center(axis), ct = boxes_[t].center(axis);
            return cs != ct ? cs < ct : s < t;
        });
        return middle;
    }

    TriangleBvh& bvh_;
    std::vector<FloatBox> boxes_;
};

TriangleBvh::TriangleBvh(std::span<const Vec3d> positions, std::span<const Triangle> triangles)
    : positions_(positions), triangles_(triangles), order_(triangles.size()) {
    if (triangles.empty()) return;
    Box box;
    for (const Triangle& t : triangles) {
        for (Index v : t) box.extend(positions[v]);
    }
    origin_ = box.center();
    std::iota(order_.begin(), order_.end(), Index{0});
    nodes_.reserve(triangles.size());
    BvhBuilder(*this).build(0, static_cast<Index>(triangles.size()), 0);
}

std::optional<ClosestPoint> TriangleBvh::closest(Vec3d p, double max_distance) const {
    if (nodes_.empty()) return std::nullopt;
    const Vec3d q = p - origin_;
    ClosestPoint best;
    best.squared_distance = max_distance * max_distance;
    std::array<StackEntry, kStackSize> stack;
    std::size_t top = 0;
    stack[top++] = {0, squared_distance_to_box(q, nodes_[0].low, nodes_[0].high)};
    while (top > 0) {
        const StackEntry entry = stack[--top];
        if (entry.key > best.squared_distance) continue;
        const Node& node = nodes_[entry.node];
        for (Index i = node.first; i < node.first + node.count; ++i) {
            const Index t = order_[i];
            const Triangle& v = triangles_[t];
            ClosestPoint c =
                closest_point_on_triangle(p, positions_[v[0]], positions_[v[1]], positions_[v[2]]);
            if (c.squared_distance > best.squared_distance ||
                (c.squared_distance == best.squared_distance && t > best.triangle))
                continue;
            c.triangle = t;
            best = c;
        }
        if (node.count > 0) continue;
        const Index left = entry.node + 1, right = node.first;
        StackEntry near{left, squared_distance_to_box(q, nodes_[left].low, nodes_[left].high)};
        StackEntry far{right, squared_distance_to_box(q, nodes_[right].low, nodes_[right].high)};
        if (far.key < near.key) std::swap(near, far);
        if (far.key <= best.squared_distance) stack[top++] = far;
        if (near.key <= best.squared_distance) stack[top++] = near;
    }
    if (best.triangle == kInvalidIndex) return std::nullopt;
    return best;
}

namespace {

// A ray sheared so that it runs along +z [Woop13].
struct ShearedRay {
    Vec3d origin;
    std::size_t kx, ky, kz;
    double sx, sy, sz;

    ShearedRay(Vec3d o, Vec3d d) : origin(o) {
        const double ax = std::fabs(d.x), ay = std::fabs(d.y), az = std::fabs(d.z);
        kz = ax >= ay && ax >= az ? 0 : (ay >= az ? 1 : 2);
        kx = (kz + 1) % 3, ky = (kz + 2) % 3;
        if (d[kz] < 0.0) std::swap(kx, ky);
        sx = d[kx] / d[kz], sy = d[ky] / d[kz], sz = 1.0 / d[kz];
    }

    std::optional<RayHit> hit(Vec3d a, Vec3d b, Vec3d c) const {
        a = a - origin, b = b - origin, c = c - origin;
        const double az = a[kz] * sz, bz = b[kz] * sz, cz = c[kz] * sz;
        const double ax = a[kx] - sx * a[kz], ay = a[ky] - sy * a[kz];
        const double bx = b[kx] - sx * b[kz], by = b[ky] - sy * b[kz];
        const double cx = c[kx] - sx * c[kz], cy = c[ky] - sy * c[kz];
        const double u = cx * by - cy * bx, v = ax * cy - ay * cx, w = bx * ay - by * ax;
        if ((u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0)) return {};
        const double sum = u + v + w;
        if (sum == 0.0) return {};
        return RayHit{kInvalidIndex, (u * az + v * bz + w * cz) / sum, {u / sum, v / sum, w / sum}};
    }
};

// Where the ray enters the box, or infinity if it misses it within [0, max_t].
double box_entry(Vec3d o, Vec3d d, Vec3f low, Vec3f high, double max_t) {
    double enter = 0.0, leave = max_t;
    for (std::size_t k = 0; k < 3; ++k) {
        if (d[k] == 0.0) {
            if (o[k] < low[k] || o[k] > high[k]) return HUGE_VAL;
            continue;
        }
        const double t0 = (low[k] - o[k]) / d[k], t1 = (high[k] - o[k]) / d[k];
        enter = std::max(enter, std::min(t0, t1));
        leave = std::min(leave, std::max(t0, t1) * kSlabGrowth);
    }
    return enter <= leave ? enter : HUGE_VAL;
}

}  // namespace

std::optional<RayHit> TriangleBvh::first_hit(Vec3d origin, Vec3d direction, double max_t) const {
    if (nodes_.empty() || !(squared_length(direction) > 0.0)) return std::nullopt;
    const ShearedRay ray(origin, direction);
    const Vec3d o = origin - origin_;
    const auto entry_of = [&](Index node, double limit) {
        return StackEntry{node,
                          box_entry(o, direction, nodes_[node].low, nodes_[node].high, limit)};
    };
    RayHit best;
    best.t = max_t;
    std::array<StackEntry, kStackSize> stack;
    std::size_t top = 0;
    stack[top++] = entry_of(0, max_t);
    while (top > 0) {
        const StackEntry entry = stack[--top];
        if (entry.key == HUGE_VAL || entry.key > best.t * kSlabGrowth) continue;
        const Node& node = nodes_[entry.node];
        for (Index i = node.first; i < node.first + node.count; ++i) {
            const Index t = order_[i];
            const Triangle& v = triangles_[t];
            const auto hit = ray.hit(positions_[v[0]], positions_[v[1]], positions_[v[2]]);
            if (!hit || !(hit->t > 0.0) || hit->t > best.t ||
                (hit->t == best.t && t > best.triangle))
                continue;
            best = *hit;
            best.triangle = t;
        }
        if (node.count > 0) continue;
        StackEntry near = entry_of(entry.node + 1, best.t), far = entry_of(node.first, best.t);
        if (far.key < near.key) std::swap(near, far);
        if (far.key != HUGE_VAL) stack[top++] = far;
        if (near.key != HUGE_VAL) stack[top++] = near;
    }
    if (best.triangle == kInvalidIndex) return std::nullopt;
    return best;
}

}  // namespace pointbake
