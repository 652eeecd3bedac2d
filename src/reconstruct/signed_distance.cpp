// After [Hoppe92]: the distance to the tangent plane at the nearest point, here blended over the
// near points [Kolluri05] with weights for those whose normals agree, found by iteration
// [Oztireli09]: sheets that lie close together do not mix and creases stay.
//
// Departure: a point p with normal m says of a place x with normal n not (x - p) . m but
// (x - p) . (m + n) / 2. This is 0 for any two points of a sphere or a cylinder [Rusinkiewicz19],
// so the surface does not shrink where it is curved, and wide kernels (noise) are affordable.
#include "reconstruct/signed_distance.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <tuple>
#include <utility>

#include "core/morton.h"
#include "core/parallel.h"
#include "core/parallel_sort.h"

namespace pointbake {
namespace {

constexpr std::size_t kLeafSize = 8, kGrain = 4096;

// Radius of the fit's kernel in spacings; the kernel (1 - q)^4 is like a Gaussian of radius / 2.8.
// Measured: see docs/stages/reconstruct.md.
constexpr double kWidth = 2.0, kWidthPerRootNoise = 6.0;
// Radius of the kernel that measures density. It must hold so many points that chance leaves no
// holes in random samples.
constexpr float kDensityWidth = 4.5F;
constexpr int kIterations = 3;
// Inside a sampled surface the nearest point is not farther than this, in spacings.
constexpr float kSureDistance = 0.75F;
// A point that is nearer by this factor counts more than those in reach.
constexpr double kNearerShare = 0.8;
// Normals that differ by more than this cosine are a crease or another sheet.
constexpr float kBentCosine = 0.6F, kBentShare = 0.02F;

float square(float v) { return v * v; }
float fourth(float v) { return square(square(v)); }

// Weight for normals that agree: a half at 33 degrees, 0 from 90.
float agreement(float cosine) { return cosine > 0.0F ? fourth(cosine) : 0.0F; }

double squared(double v) { return v * v; }

/// How far an interval ends below 0 or begins above it.
double gap(double low, double high) { return low > 0.0 ? low : (high < 0.0 ? -high : 0.0); }

double squared_distance(const Box& a, const Box& b) {
    return squared(gap(a.low.x - b.high.x, a.high.x - b.low.x)) +
           squared(gap(a.low.y - b.high.y, a.high.y - b.low.y)) +
           squared(gap(a.low.z - b.high.z, a.high.z - b.low.z));
}
double squared_distance(const Box& a, Vec3d p) {
    return squared(gap(a.low.x - p.x, a.high.x - p.x)) +
           squared(gap(a.low.y - p.y, a.high.y - p.y)) +
           squared(gap(a.low.z - p.z, a.high.z - p.z));
}

// Morton code of a place on a grid anchored at the origin, so that the order of two points does not
// depend on the others. Coordinates wrap around: that costs speed alone.
std::uint64_t morton(Vec3d p, double cells_per_unit) {
    const auto cell = [&](double v) {
        return static_cast<std::uint64_t>(
            static_cast<std::int64_t>(std::floor(v * cells_per_unit)));
    };
    return morton_code(cell(p.x), cell(p.y), cell(p.z));
}

}  // namespace

/// The surface near a place, as a plane: signed distance and normal.
struct SignedDistance::Fit {
    float value = 0.0F;
    Vec3f normal;
    bool has_points = false;  ///< around the foot point
};

SignedDistance::SignedDistance(std::span<const Vec3d> points, std::span<const Vec3f> normals,
                               std::span<const float> spacing, double noise, const Context& context)
    : noise_(noise) {
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (squared_length(normals[i]) == 0.0F || !(spacing[i] > 0.0F)) continue;
        points_.push_back({points[i], normals[i], spacing[i]});
        box_.extend(points[i]);
        min_spacing_ = points_.size() == 1 ? spacing[i] : std::min(min_spacing_, spacing[i]);
    }
    width_ = static_cast<float>(kWidth + kWidthPerRootNoise * std::sqrt(noise));
    reach_ = std::max(width_, kDensityWidth);
    if (points_.empty()) return;
    sort_points(context);
    build_tree(context);
}

void SignedDistance::sort_points(const Context& context) {
    const Vec3d extent = box_.extent();
    // A power of two, so that a larger box gives the same order.
    constexpr int kBits = 20;
    const double longest = std::max({extent.x, extent.y, extent.z, double{min_spacing_}});
    cells_per_unit_ = std::ldexp(1.0, kBits - std::ilogb(longest) - 1);
    struct Keyed {
        std::uint64_t code;
        Index id;
    };
    std::vector<Keyed> keys(points_.size());
    parallel_for(context, keys.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            keys[i] = {morton(points_[i].position, cells_per_unit_), static_cast<Index>(i)};
    });
    parallel_sort(context, keys, [&](const Keyed& a, const Keyed& b) {
        if (a.code != b.code) return a.code < b.code;
        const Vec3d &p = points_[a.id].position, &q = points_[b.id].position;
        return std::tie(p.x, p.y, p.z, a.id) < std::tie(q.x, q.y, q.z, b.id);
    });
    std::vector<Point> sorted(points_.size());
    for (std::size_t i = 0; i < keys.size(); ++i) sorted[i] = points_[keys[i].id];
    points_ = std::move(sorted);
}

SignedDistance::Node SignedDistance::leaf_node(std::size_t leaf) const {
    Node node;
    const std::size_t end = std::min(points_.size(), (leaf + 1) * kLeafSize);
    for (std::size_t i = leaf * kLeafSize; i < end; ++i) {
        node.box.extend(points_[i].position);
        const float reach = reach_ * points_[i].spacing;
        node.reach = std::max(node.reach, reach);
        node.least_reach = i == leaf * kLeafSize ? reach : std::min(node.least_reach, reach);
    }
    return node;
}

void SignedDistance::build_tree(const Context& context) {
    num_leaves_ = std::bit_ceil((points_.size() + kLeafSize - 1) / kLeafSize);
    nodes_.resize(2 * num_leaves_ - 1);
    parallel_for(context, num_leaves_, kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) nodes_[num_leaves_ - 1 + i] = leaf_node(i);
    });
    for (std::size_t k = num_leaves_ - 1; k-- > 0;) {
        const Node &a = nodes_[2 * k + 1], &b = nodes_[2 * k + 2];
        nodes_[k] = a;
        if (b.box.is_empty()) continue;
        nodes_[k].box.extend(b.box.low), nodes_[k].box.extend(b.box.high);
        nodes_[k].reach = std::max(a.reach, b.reach);
        nodes_[k].least_reach = std::min(a.least_reach, b.least_reach);
    }
}

/// Calls visit_point for the points of all leaves that is_near(node) lets through, in order, until
/// it returns false.
template <class IsNear, class Visit>
void SignedDistance::visit(IsNear&& is_near, Visit&& visit_point) const {
    if (points_.empty()) return;
    std::array<std::size_t, 64> stack;
    std::size_t depth = 0;
    stack[depth++] = 0;
    while (depth > 0) {
        const std::size_t k = stack[--depth];
        if (nodes_[k].box.is_empty() || !is_near(nodes_[k])) continue;
        if (k < num_leaves_ - 1) {
            stack[depth++] = 2 * k + 2;
            stack[depth++] = 2 * k + 1;
            continue;
        }
        const std::size_t begin = (k - (num_leaves_ - 1)) * kLeafSize;
        const std::size_t end = std::min(points_.size(), begin + kLeafSize);
        for (std::size_t i = begin; i < end; ++i)
            if (!visit_point(points_[i])) return;
    }
}

bool SignedDistance::has_point_within(Vec3d place, double radius, double most_reach) const {
    const double radius2 = radius * radius;
    bool found = false;
    visit(
        [&](const Node& node) {
            return double{node.least_reach} <= most_reach &&
                   squared_distance(node.box, place) <= radius2;
        },
        [&](const Point& p) {
            found = squared_length(p.position - place) <= radius2 &&
                    double{reach_ * p.spacing} <= most_reach;
            return !found;
        });
    return found;
}

/// Gathers near points for one place after the other. Keeps those around a small cube, for the next
/// places that fall into it; what it gives does not depend on that.
class SignedDistance::Cursor {
 public:
    explicit Cursor(const SignedDistance& field)
        : field_(field), last_reach_(double{field.reach_} * field.min_spacing_) {}

    std::span<const Near> near(Vec3d place) {
        const Vec3d d = place - center_;
        if (!(std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)}) <= half_)) move_to(place);
        // All are written, those out of reach over by the next: no branch to guess.
        near_.resize(around_.size() + 1);
        std::size_t count = 0;
        for (const Around& p : around_) {
            const Vec3f offset = vec_cast<float>(place - p.position);
            const float q = squared_length(offset) * p.per_reach2;
            near_[count] = {offset, p.normal, p.spacing, p.fineness, q};
            count += q < 1.0F ? 1 : 0;
        }
        near_.resize(count);
        return near_;
    }

 private:
    struct Around {
        Vec3d position;
        Vec3f normal;
        float spacing, fineness;
        float per_reach2;  ///< one over the squared reach
    };

    // Edge of the cube in reaches, at most: places per cube against points around it.
    static constexpr double kEdge = 2.4;

    /// To the cell of the Morton codes' grid, or rather of a coarser one, that holds the place:
    /// places in Morton order leave it once. Smaller ones are tried while the points around are
    /// finer than those before.
    void move_to(Vec3d place) {
        for (double reach = last_reach_;; reach = last_reach_) {
            const double cells_per_unit = field_.cells_per_unit_;
            const double edge =
                std::ldexp(1.0, std::ilogb(kEdge * reach * cells_per_unit)) / cells_per_unit;
            const auto low = [&](double v) { return std::floor(v / edge) * edge; };
            const Vec3d corner{low(place.x), low(place.y), low(place.z)};
            gather({corner, corner + Vec3d{edge, edge, edge}});
            if (around_.empty()) return;
            const auto finest = std::ranges::min_element(around_, {}, &Around::spacing);
            last_reach_ = double{field_.reach_} * finest->spacing;
            if (last_reach_ >= 0.5 * reach) return;
        }
    }

    void gather(const Box& cube) {
        center_ = cube.center();
        half_ = 0.5 * (cube.high.x - cube.low.x);
        around_.clear();
        field_.visit(
            [&](const Node& node) {
                return squared_distance(node.box, cube) < double{node.reach} * node.reach;
            },
            [&](const Point& p) {
                const double reach = double{field_.reach_} * p.spacing;
                if (squared_distance(cube, p.position) < reach * reach)
                    around_.push_back({p.position, p.normal, p.spacing, 1.0F / square(p.spacing),
                                       1.0F / square(field_.reach_ * p.spacing)});
                return true;
            });
    }

    const SignedDistance& field_;
    Vec3d center_;
    double half_ = -1.0;
    double last_reach_;  ///< of the finest point around the last cube that had any
    std::vector<Around> around_;
    std::vector<Near> near_;
};

/// The nearest points decide which sheet it is.
SignedDistance::Fit SignedDistance::first_fit(std::span<const Near> near) const {
    Vec3f normal;
    const Near* nearest = &near.front();
    for (const Near& p : near) {
        normal += p.normal * (p.fineness * square(fourth(1.0F - p.q)));
        if (p.q < nearest->q) nearest = &p;
    }
    normal = normalized(normal);
    if (squared_length(normal) == 0.0F) normal = nearest->normal;
    float sum = 0.0F, value = 0.0F;
    for (const Near& p : near) {
        const float cosine = dot(p.normal, normal);
        if (cosine <= 0.0F) continue;
        const float w = p.fineness * square(fourth(1.0F - p.q)) * cosine;
        sum += w;
        value += w * dot(p.offset, p.normal + normal);
    }
    if (sum > 0.0F) return {0.5F * value / sum, normal};
    return {dot(nearest->offset, nearest->normal), nearest->normal};
}

/// Weights around the foot point, which do not fade with the height above the surface.
SignedDistance::Fit SignedDistance::refine(std::span<const Near> near, const Fit& fit) const {
    float sum = 0.0F, along = 0.0F;
    Vec3f offset, normal;
    const Vec3f height = fit.normal * fit.value;
    for (const Near& p : near) {
        const float q = squared_length(p.offset - height) / square(width_ * p.spacing);
        if (q >= 1.0F) continue;
        const float w = p.fineness * fourth(1.0F - q) * agreement(dot(p.normal, fit.normal));
        sum += w;
        normal += p.normal * w;
        offset += p.offset * w;
        along += w * dot(p.offset, p.normal);
    }
    if (!(sum > 0.0F)) return {fit.value, fit.normal, false};
    normal = normalized(normal);
    return {0.5F * (along + dot(offset, normal)) / sum, normal, true};
}

FieldSample SignedDistance::describe(std::span<const Near> near, const Fit& fit) const {
    float density = 0.0F, all = 0.0F, bent = 0.0F, sum = 0.0F, fineness = 0.0F;
    const float sheet = 2.0F + 3.0F * static_cast<float>(noise_);
    for (const Near& p : near) {
        const float cosine = dot(p.normal, fit.normal);
        const float w = square(1.0F - p.q);
        all += w;
        if (cosine < kBentCosine) bent += w;
        sum += w * w;
        fineness += w * w * p.fineness;
        const float height = dot(p.offset, fit.normal);
        const float q =
            (squared_length(p.offset) - square(height)) / square(kDensityWidth * p.spacing);
        if (q < 1.0F && cosine > 0.0F && std::abs(height - fit.value) < sheet * p.spacing)
            density += fourth(1.0F - q);
    }
    FieldSample s;
    s.is_known = true;
    s.value = fit.value;
    s.normal = fit.normal;
    s.spacing = sum > 0.0F ? std::sqrt(sum / fineness) : near.front().spacing;
    // Points of a plane, one per square of their spacing: the kernel's integral over the plane.
    constexpr float kWhole = 3.14159265F / 5.0F * kDensityWidth * kDensityWidth;
    s.density = fit.has_points ? density / kWhole : 0.0F;
    s.is_bent = bent > kBentShare * all;
    return s;
}

/// Points much finer than those in reach may be nearer and yet not reach the place: then the
/// others, which end somewhere before them, are no guide. Only one whose reach is shorter than the
/// distance can be nearer and not reach the place.
bool SignedDistance::is_overreached(Vec3d place, std::span<const Near> near) const {
    const auto distance2 = [](const Near& p) { return squared_length(p.offset); };
    const Near& nearest = *std::ranges::min_element(near, {}, distance2);
    const double distance = length(nearest.offset);
    return distance > kSureDistance * nearest.spacing &&
           has_point_within(place, kNearerShare * distance, distance);
}

FieldSample SignedDistance::describe(Vec3d place, std::span<const Near> near) const {
    if (near.empty() || is_overreached(place, near)) return {};
    Fit fit = first_fit(near);
    for (int k = 0; k < kIterations; ++k) fit = refine(near, fit);
    return describe(near, fit);
}

std::vector<FieldSample> SignedDistance::at(std::span<const Vec3d> places,
                                            const Context& context) const {
    std::vector<std::pair<std::uint64_t, std::size_t>> order(places.size());
    parallel_for(context, places.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            order[i] = {morton(places[i], cells_per_unit_), i};
    });
    parallel_sort(context, order);
    std::vector<FieldSample> samples(places.size());
    parallel_for(context, places.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        Cursor cursor(*this);
        for (std::size_t k = begin; k < end; ++k) {
            const std::size_t i = order[k].second;
            samples[i] = describe(places[i], cursor.near(places[i]));
        }
    });
    return samples;
}

}  // namespace pointbake
