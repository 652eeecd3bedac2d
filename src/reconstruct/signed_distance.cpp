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
#include <cstring>
#include <tuple>
#include <utility>

#include "core/median.h"
#include "core/morton.h"
#include "core/parallel.h"
#include "core/parallel_sort.h"

namespace pointbake {
namespace {

constexpr std::size_t kGrain = 4096;

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

// Four sums at once, added up in the end: as many for all processors, so that all round alike.
using Lanes = float __attribute__((vector_size(16)));
using Vec3l = Vec3<Lanes>;
constexpr std::size_t kLanes = 4;

Lanes spread(float v) { return Lanes{v, v, v, v}; }
Vec3l spread(Vec3f v) { return {spread(v.x), spread(v.y), spread(v.z)}; }
Lanes load(const float* from) {
    Lanes v;
    std::memcpy(&v, from, sizeof v);
    return v;
}
Vec3l load(const Vec3<std::array<float, 8>>& v, std::size_t first) {
    return {load(&v.x[first]), load(&v.y[first]), load(&v.z[first])};
}
float total(Lanes v) { return (v[0] + v[1]) + (v[2] + v[3]); }
Vec3f total(const Vec3l& v) { return {total(v.x), total(v.y), total(v.z)}; }
Lanes positive(Lanes v) { return v > 0.0F ? v : Lanes{}; }
Lanes square(Lanes v) { return v * v; }
Lanes fourth(Lanes v) { return square(square(v)); }
float square(float v) { return v * v; }

// Weight for normals that agree: a half at 33 degrees, 0 from 90.
Lanes agreement(Lanes cosine) { return fourth(positive(cosine)); }

double squared(double v) { return v * v; }

double squared_distance(const Box& a, const Box& b) {
    const auto gap = [&](std::size_t k) {
        return squared(std::max(std::max(a.low[k] - b.high[k], b.low[k] - a.high[k]), 0.0));
    };
    return gap(0) + gap(1) + gap(2);
}
/// From a place to the farthest corner.
double farthest_squared_distance(const Box& a, Vec3d p) {
    const auto far = [&](std::size_t k) {
        return squared(std::max(a.high[k] - p[k], p[k] - a.low[k]));
    };
    return far(0) + far(1) + far(2);
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

SignedDistance::SignedDistance(std::span<const Vec3d> positions, std::span<const Vec3f> normals,
                               std::span<const float> spacing, double noise, const Context& context)
    : noise_(noise) {
    std::vector<Point> points;
    std::vector<float> spacings;
    for (std::size_t i = 0; i < positions.size(); ++i) {
        if (squared_length(normals[i]) == 0.0F || !(spacing[i] > 0.0F)) continue;
        points.push_back({positions[i], normals[i], spacing[i]});
        box_.extend(positions[i]);
        min_spacing_ = points.size() == 1 ? spacing[i] : std::min(min_spacing_, spacing[i]);
        spacings.push_back(spacing[i]);
    }
    median_spacing_ = median_in_place(std::span(spacings));
    num_points_ = points.size();
    width_ = static_cast<float>(kWidth + kWidthPerRootNoise * std::sqrt(noise));
    reach_ = std::max(width_, kDensityWidth);
    if (points.empty()) return;
    const Vec3d extent = box_.extent();
    // A power of two, so that a larger box gives the same order.
    constexpr int kBits = 20;
    const double longest = std::max({extent.x, extent.y, extent.z, double{min_spacing_}});
    cells_per_unit_ = std::ldexp(1.0, kBits - std::ilogb(longest) - 1);
    sort_in_place(points, context);
    build_tree(points, context);
}

void SignedDistance::sort_in_place(std::vector<Point>& points, const Context& context) const {
    struct Keyed {
        std::uint64_t code;
        Index id;
    };
    std::vector<Keyed> keys(points.size());
    parallel_for(context, keys.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            keys[i] = {morton(points[i].position, cells_per_unit_), static_cast<Index>(i)};
    });
    parallel_sort(context, keys, [&](const Keyed& a, const Keyed& b) {
        if (a.code != b.code) return a.code < b.code;
        const Vec3d &p = points[a.id].position, &q = points[b.id].position;
        return std::tie(p.x, p.y, p.z, a.id) < std::tie(q.x, q.y, q.z, b.id);
    });
    std::vector<Point> sorted(points.size());
    for (std::size_t i = 0; i < keys.size(); ++i) sorted[i] = points[keys[i].id];
    points = std::move(sorted);
}

SignedDistance::Node SignedDistance::make_node(std::span<const Point> points) const {
    Node node;
    node.least_reach = reach_ * points.front().spacing;
    for (const Point& p : points) {
        node.box.extend(p.position);
        node.reach = std::max(node.reach, reach_ * p.spacing);
        node.least_reach = std::min(node.least_reach, reach_ * p.spacing);
    }
    return node;
}

SignedDistance::Leaf SignedDistance::make_leaf(std::span<const Point> points,
                                               const Node& node) const {
    Leaf leaf{};
    leaf.center = node.box.center();
    leaf.half = vec_cast<float>(node.box.extent() * 0.5);
    leaf.reach = node.reach;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Vec3f position = vec_cast<float>(points[i].position - leaf.center);
        for (std::size_t k = 0; k < 3; ++k) {
            leaf.position[k][i] = position[k];
            leaf.normal[k][i] = points[i].normal[k];
        }
        leaf.fineness[i] = 1.0F / square(points[i].spacing);
    }
    return leaf;
}

void SignedDistance::build_tree(std::span<const Point> points, const Context& context) {
    leaves_.resize((points.size() + Leaf::kSize - 1) / Leaf::kSize);
    num_leaves_ = std::bit_ceil(leaves_.size());
    nodes_.resize(2 * num_leaves_ - 1);
    parallel_for(context, leaves_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const std::size_t first = i * Leaf::kSize;
            const auto items = points.subspan(first, std::min(Leaf::kSize, points.size() - first));
            Node& node = nodes_[num_leaves_ - 1 + i];
            node = make_node(items);
            leaves_[i] = make_leaf(items, node);
        }
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

/// Calls visit_leaf for all leaves that is_near(node) lets through, in order.
template <class IsNear, class Visit>
void SignedDistance::visit(IsNear&& is_near, Visit&& visit_leaf) const {
    if (nodes_.empty()) return;
    std::array<std::size_t, 64> stack;
    std::size_t depth = 0;
    stack[depth++] = 0;
    while (depth > 0) {
        const std::size_t k = stack[--depth];
        if (nodes_[k].box.is_empty() || !is_near(nodes_[k])) continue;
        if (k < num_leaves_ - 1) {
            stack[depth++] = 2 * k + 2;
            stack[depth++] = 2 * k + 1;
        } else {
            visit_leaf(leaves_[k - (num_leaves_ - 1)]);
        }
    }
}

bool SignedDistance::has_point_within(Vec3d place, double radius, double most_reach) const {
    const double radius2 = radius * radius;
    const auto least_fineness = static_cast<float>(squared(reach_ / most_reach));
    bool found = false;
    visit(
        [&](const Node& node) {
            if (found || double{node.least_reach} > most_reach) return false;
            found = double{node.reach} <= most_reach &&
                    farthest_squared_distance(node.box, place) <= radius2;
            return !found && squared_distance(node.box, {place, place}) <= radius2;
        },
        [&](const Leaf& leaf) {
            const Vec3f at = vec_cast<float>(place - leaf.center);
            for (std::size_t i = 0; i < Leaf::kSize; ++i) {
                const Vec3f p{leaf.position.x[i], leaf.position.y[i], leaf.position.z[i]};
                found |= leaf.fineness[i] > 0.0F && leaf.fineness[i] >= least_fineness &&
                         squared_length(p - at) <= static_cast<float>(radius2);
            }
        });
    return found;
}

/// Gathers near points for one place after the other. Keeps the leaves around a small cube, for the
/// next places that fall into it; what it gives does not depend on that.
class SignedDistance::Cursor {
 public:
    explicit Cursor(const SignedDistance& field)
        : field_(field), last_reach_(double{field.reach_} * field.min_spacing_) {}

    std::span<const Near> near(Vec3d place) {
        const Vec3d d = place - center_;
        if (!(std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)}) <= half_)) move_to(place);
        near_.clear();
        for (const Leaf* leaf : around_) {
            const Vec3f at = vec_cast<float>(place - leaf->center);
            const auto gap = [&](std::size_t k) {
                return square(std::max(std::abs(at[k]) - leaf->half[k], 0.0F));
            };
            if (gap(0) + gap(1) + gap(2) < square(leaf->reach)) add(*leaf, at);
        }
        return near_;
    }

 private:
    // Edge of the cube in reaches, at most: places per cube against leaves around it.
    static constexpr double kEdge = 2.4;

    void add(const Leaf& leaf, Vec3f place) {
        Near near{&leaf, place, {}};
        const Vec3l at = spread(place);
        const float reach2 = square(field_.reach_);
        Lanes sum{};
        for (std::size_t i = 0; i < Leaf::kSize; i += kLanes) {
            Lanes fineness = load(&leaf.fineness[i]);
            const Lanes q = squared_length(at - load(leaf.position, i)) * fineness;
            fineness = q < reach2 ? fineness : Lanes{};
            std::memcpy(&near.fineness[i], &fineness, sizeof fineness);
            sum += fineness;
        }
        if (total(sum) > 0.0F) near_.push_back(near);
    }

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
            last_reach_ = finest_;
            if (last_reach_ >= 0.5 * reach) return;
        }
    }

    void gather(const Box& cube) {
        center_ = cube.center();
        half_ = 0.5 * (cube.high.x - cube.low.x);
        around_.clear();
        finest_ = HUGE_VAL;
        double least_reach = 0.0;
        field_.visit(
            [&](const Node& node) {
                least_reach = node.least_reach;
                return squared_distance(node.box, cube) < double{node.reach} * node.reach;
            },
            [&](const Leaf& leaf) {
                around_.push_back(&leaf);
                finest_ = std::min(finest_, least_reach);
            });
    }

    const SignedDistance& field_;
    Vec3d center_;
    double half_ = -1.0;
    double finest_ = 0.0;  ///< least reach around the cube
    double last_reach_;    ///< of the finest point around the last cube that had any
    std::vector<const Leaf*> around_;
    std::vector<Near> near_;
};

/// Calls visit(offset, normal, fineness) for the near points, some at once. Offsets run from the
/// points to the place; the fineness is 0 where a lane holds no near point.
template <class Visit>
void SignedDistance::for_each(std::span<const Near> near, Visit&& visit_lanes) {
    for (const Near& n : near) {
        const Vec3l place = spread(n.place);
        for (std::size_t i = 0; i < Leaf::kSize; i += kLanes)
            visit_lanes(place - load(n.leaf->position, i), load(n.leaf->normal, i),
                        load(&n.fineness[i]));
    }
}

/// The nearest points decide which sheet it is.
SignedDistance::Start SignedDistance::start(std::span<const Near> near) const {
    const float per_reach2 = 1.0F / square(reach_);
    Vec3l normal{};
    Lanes distance2 = spread(HUGE_VALF), finest{};
    for_each(near, [&](const Vec3l& offset, const Vec3l& n, Lanes fineness) {
        const Lanes d2 = squared_length(offset);
        const Lanes closeness = positive(1.0F - d2 * fineness * per_reach2);
        normal += n * (fineness * square(fourth(closeness)));
        const auto is_nearer = (fineness > 0.0F) & (d2 < distance2);
        distance2 = is_nearer ? d2 : distance2;
        finest = is_nearer ? fineness : finest;
    });
    std::size_t k = 0;
    for (std::size_t i = 1; i < kLanes; ++i)
        if (distance2[i] < distance2[k]) k = i;
    return {total(normal), distance2[k], finest[k]};
}

SignedDistance::Fit SignedDistance::nearest_fit(std::span<const Near> near) const {
    Fit fit;
    float least = HUGE_VALF;
    for (const Near& n : near)
        for (std::size_t i = 0; i < Leaf::kSize; ++i) {
            const auto& [x, y, z] = n.leaf->position;
            const Vec3f offset = n.place - Vec3f{x[i], y[i], z[i]};
            const float q = squared_length(offset) * n.fineness[i];
            if (n.fineness[i] == 0.0F || q >= least) continue;
            least = q;
            fit.normal = {n.leaf->normal.x[i], n.leaf->normal.y[i], n.leaf->normal.z[i]};
            fit.value = dot(offset, fit.normal);
        }
    return fit;
}

SignedDistance::Fit SignedDistance::first_fit(std::span<const Near> near, Vec3f normal) const {
    normal = normalized(normal);
    if (squared_length(normal) == 0.0F) normal = nearest_fit(near).normal;
    const float per_reach2 = 1.0F / square(reach_);
    const Vec3l up = spread(normal);
    Lanes sum{}, value{};
    for_each(near, [&](const Vec3l& offset, const Vec3l& n, Lanes fineness) {
        const Lanes closeness = positive(1.0F - squared_length(offset) * fineness * per_reach2);
        const Lanes w = fineness * square(fourth(closeness)) * positive(dot(n, up));
        sum += w;
        value += w * dot(offset, n + up);
    });
    if (total(sum) > 0.0F) return {0.5F * total(value) / total(sum), normal};
    return nearest_fit(near);
}

/// Weights around the foot point, which do not fade with the height above the surface.
SignedDistance::Fit SignedDistance::refine(std::span<const Near> near, const Fit& fit) const {
    const float per_width2 = 1.0F / square(width_);
    const Vec3l up = spread(fit.normal), height = spread(fit.normal * fit.value);
    Lanes sum{}, along{};
    Vec3l offset{}, normal{};
    for_each(near, [&](const Vec3l& to, const Vec3l& n, Lanes fineness) {
        const Lanes closeness =
            positive(1.0F - squared_length(to - height) * fineness * per_width2);
        const Lanes w = fineness * fourth(closeness) * agreement(dot(n, up));
        sum += w;
        normal += n * w;
        offset += to * w;
        along += w * dot(to, n);
    });
    const float weight = total(sum);
    if (!(weight > 0.0F)) return {fit.value, fit.normal, false};
    const Vec3f unit = normalized(total(normal));
    return {0.5F * (total(along) + dot(total(offset), unit)) / weight, unit, true};
}

FieldSample SignedDistance::describe(std::span<const Near> near, const Fit& fit) const {
    const float per_reach2 = 1.0F / square(reach_), per_density2 = 1.0F / square(kDensityWidth);
    const float sheet2 = square(2.0F + 3.0F * static_cast<float>(noise_));
    const Vec3l up = spread(fit.normal);
    Lanes density{}, all{}, bent{}, sum{}, fineness{};
    for_each(near, [&](const Vec3l& offset, const Vec3l& n, Lanes f) {
        const Lanes cosine = dot(n, up), height = dot(offset, up);
        const Lanes d2 = squared_length(offset);
        const Lanes w = f > 0.0F ? square(positive(1.0F - d2 * f * per_reach2)) : Lanes{};
        all += w;
        bent += cosine < kBentCosine ? w : Lanes{};
        sum += w * w;
        fineness += w * w * f;
        const Lanes closeness = positive(1.0F - (d2 - square(height)) * f * per_density2);
        const auto is_of_sheet =
            (f > 0.0F) & (cosine > 0.0F) & (square(height - fit.value) * f < sheet2);
        density += is_of_sheet ? fourth(closeness) : Lanes{};
    });
    FieldSample s;
    s.is_known = true;
    s.value = fit.value;
    s.normal = fit.normal;
    s.spacing = std::sqrt(total(sum) / total(fineness));
    // Points of a plane, one per square of their spacing: the kernel's integral over the plane.
    constexpr float kWhole = 3.14159265F / 5.0F * kDensityWidth * kDensityWidth;
    s.density = fit.has_points ? total(density) / kWhole : 0.0F;
    s.is_bent = total(bent) > kBentShare * total(all);
    return s;
}

/// Points much finer than those in reach may be nearer and yet not reach the place: then the
/// others, which end somewhere before them, are no guide. Only one whose reach is shorter than the
/// distance can be nearer and not reach the place.
bool SignedDistance::is_overreached(Vec3d place, const Start& start) const {
    const double distance = std::sqrt(start.distance2);
    return start.distance2 * start.fineness > square(kSureDistance) &&
           has_point_within(place, kNearerShare * distance, distance);
}

FieldSample SignedDistance::describe(Vec3d place, std::span<const Near> near) const {
    if (near.empty()) return {};
    const Start begin = start(near);
    if (is_overreached(place, begin)) return {};
    Fit fit = first_fit(near, begin.normal);
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
