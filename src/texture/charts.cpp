#include "texture/charts.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <queue>
#include <utility>

#include "core/parallel.h"
#include "texture/chart_overlap.h"
#include "texture/flatten.h"
#include "texture/least_box.h"

namespace pointbake {
namespace {

constexpr double kLeastCosine = 0.5;        // of a normal to the axis; flattening does the rest
constexpr double kLeastMergedCosine = 0.3;  // once more than one proxy has grown together
constexpr double kCompact = 0.1;            // how much roundness counts next to flatness
constexpr int kGrowRounds = 12;             // of growing from better seeds
constexpr int kStraightenRounds = 16;
constexpr double kFullEnough = 0.55;  // of the smallest box: charts that are merged pack well
constexpr int kConeSteps = 32;        // of the search for an axis

struct Face {
    Vec3d normal;  // unit length; zero for triangles without an area
    Vec3d center;
    double area = 0.0;
};

std::vector<Face> faces_of(const Mesh& mesh) {
    std::vector<Face> out(mesh.triangles.size());
    for (std::size_t t = 0; t < out.size(); ++t) {
        const Triangle& tri = mesh.triangles[t];
        const Vec3d a = mesh.positions[tri[0]], b = mesh.positions[tri[1]],
                    c = mesh.positions[tri[2]];
        const Vec3d n = cross(b - a, c - a);
        out[t] = {normalized(n), (a + b + c) / 3.0, 0.5 * length(n)};
    }
    return out;
}

// The axis a chart is projected along.
struct Plane {
    Vec3d ex, ey, ez;
    Vec2d place(Vec3d p) const { return {dot(ex, p), dot(ey, p)}; }
};

Plane plane_of(Vec3d axis) {
    const Vec3d helper = std::fabs(axis.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
    const Vec3d ex = normalized(cross(helper, axis));
    return {ex, cross(axis, ex), axis};
}

class Grower {
 public:
    Grower(const Mesh& mesh, std::span<const std::array<Index, 3>> neighbors,
           const Context& context)
        : mesh_(mesh), neighbors_(neighbors), context_(context), faces_(faces_of(mesh)) {}

    Charts run() {
        grow_all();
        lay_out_all();
        merge_all();
        return result();
    }

 private:
    // --- growing -----------------------------------------------------------------------------
    struct Proxy {
        Index seed;
        Vec3d axis, center;
        double scale2 = 0.0;  // area of what it covers
    };
    struct Step {
        double cost;
        Index triangle, proxy;
        bool operator<(const Step& other) const {  // the cheapest comes out of a queue first
            if (cost != other.cost) return cost > other.cost;
            if (triangle != other.triangle) return triangle > other.triangle;
            return proxy > other.proxy;
        }
    };

    double cost(const Proxy& proxy, Index t) const {
        const Vec3d d = faces_[t].center - proxy.center;
        const double far = proxy.scale2 > 0.0 ? squared_length(d) / proxy.scale2 : 0.0;
        return 1.0 - dot(faces_[t].normal, proxy.axis) + kCompact * far;
    }
    bool fits(Index t, Vec3d axis) const {
        return !(faces_[t].area > 0.0) || dot(faces_[t].normal, axis) >= kLeastCosine;
    }

    void grow_all() {
        for (int round = 0; round < kGrowRounds; ++round) {
            check_cancelled(context_);
            flood();
            seed_what_is_left();
            recenter();
        }
        do {
            flood();
        } while (seed_what_is_left());
        straighten();
    }

    // Triangles whose border is shortened by going over to a neighbouring chart do, where they fit:
    // what grows triangle by triangle has the borders of a saw.
    void straighten() {
        for (int round = 0; round < kStraightenRounds; ++round) {
            bool moved = false;
            for (Index t = 0; t < faces_.size(); ++t) {
                if (t == proxies_[chart_of_[t]].seed) continue;
                std::array<double, 3> lengths;
                double inside = 0.0;
                for (std::size_t k = 0; k < 3; ++k) {
                    lengths[k] = edge_length(t, k);
                    if (chart_at(t, k) == chart_of_[t]) inside += lengths[k];
                }
                double best = inside;
                Index to = chart_of_[t];
                for (std::size_t k = 0; k < 3; ++k) {
                    const Index other = chart_at(t, k);
                    if (other == kInvalidIndex || other == chart_of_[t]) continue;
                    double shared = 0.0;
                    for (std::size_t j = 0; j < 3; ++j)
                        if (chart_at(t, j) == other) shared += lengths[j];
                    if (shared > best * (1.0 + 1e-9) && fits(t, proxies_[other].axis))
                        best = shared, to = other;
                }
                if (to == chart_of_[t]) continue;
                chart_of_[t] = to;
                moved = true;
            }
            if (!moved) return;
        }
    }
    Index chart_at(Index t, std::size_t k) const {
        const Index next = neighbors_[t][k];
        return next == kInvalidIndex ? kInvalidIndex : chart_of_[next];
    }
    double edge_length(Index t, std::size_t k) const {
        const Triangle& tri = mesh_.triangles[t];
        return length(mesh_.positions[tri[(k + 1) % 3]] - mesh_.positions[tri[k]]);
    }

    // Every proxy grows over the triangles that it fits best.
    void flood() {
        chart_of_.assign(faces_.size(), kInvalidIndex);
        std::priority_queue<Step> queue;
        for (Index p = 0; p < proxies_.size(); ++p) queue.push({-1.0, proxies_[p].seed, p});
        while (!queue.empty()) {
            const Step step = queue.top();
            queue.pop();
            if (chart_of_[step.triangle] != kInvalidIndex) continue;
            chart_of_[step.triangle] = step.proxy;
            for (const Index next : neighbors_[step.triangle])
                if (next != kInvalidIndex && chart_of_[next] == kInvalidIndex &&
                    fits(next, proxies_[step.proxy].axis))
                    queue.push({cost(proxies_[step.proxy], next), next, step.proxy});
        }
    }

    // One more proxy in the middle of each connected part that none covers.
    bool seed_what_is_left() {
        const std::size_t before = proxies_.size();
        std::vector<std::uint8_t> seen(faces_.size(), 0);
        for (Index t = 0; t < faces_.size(); ++t) {
            if (chart_of_[t] != kInvalidIndex || seen[t]) continue;
            const Index seed = middle_of_uncovered(t, seen);
            proxies_.push_back({seed, faces_[seed].normal, faces_[seed].center, 0.0});
        }
        return proxies_.size() > before;
    }

    // The triangle that is most edges away from the covered ones.
    Index middle_of_uncovered(Index start, std::vector<std::uint8_t>& seen) const {
        std::vector<Index> part{start};
        seen[start] = 1;
        for (std::size_t head = 0; head < part.size(); ++head)
            for (const Index next : neighbors_[part[head]])
                if (next != kInvalidIndex && chart_of_[next] == kInvalidIndex && !seen[next])
                    seen[next] = 1, part.push_back(next);
        std::vector<Index> queue;
        for (const Index t : part)
            for (const Index next : neighbors_[t])
                if (next == kInvalidIndex || chart_of_[next] != kInvalidIndex) {
                    queue.push_back(t);
                    seen[t] = 2;
                    break;
                }
        if (queue.empty()) {  // closed, and nothing covers it yet
            queue.push_back(start);
            seen[start] = 2;
        }
        for (std::size_t head = 0; head < queue.size(); ++head)
            for (const Index next : neighbors_[queue[head]])
                if (next != kInvalidIndex && seen[next] == 1) seen[next] = 2, queue.push_back(next);
        for (auto t = queue.rbegin(); t != queue.rend(); ++t)
            if (faces_[*t].area > 0.0) return *t;
        return queue.back();
    }

    // Proxies move to what they cover.
    void recenter() {
        std::vector<Vec3d> normals(proxies_.size()), centers(proxies_.size());
        std::vector<double> areas(proxies_.size(), 0.0);
        for (Index t = 0; t < faces_.size(); ++t) {
            const Index p = chart_of_[t];
            if (p == kInvalidIndex) continue;
            normals[p] += faces_[t].normal * faces_[t].area;
            centers[p] += faces_[t].center * faces_[t].area;
            areas[p] += faces_[t].area;
        }
        for (Index p = 0; p < proxies_.size(); ++p) {
            if (!(areas[p] > 0.0)) continue;
            const Vec3d axis = normalized(normals[p]);
            if (squared_length(axis) > 0.0) proxies_[p].axis = axis;
            proxies_[p].center = centers[p] / areas[p];
            proxies_[p].scale2 = areas[p];
        }
        std::vector<double> best(proxies_.size(), HUGE_VAL);
        for (Index t = 0; t < faces_.size(); ++t) {
            const Index p = chart_of_[t];
            if (p == kInvalidIndex || !(faces_[t].area > 0.0) || !fits(t, proxies_[p].axis))
                continue;
            const double c = cost(proxies_[p], t);
            if (c < best[p]) best[p] = c, proxies_[p].seed = t;
        }
        // One whose own triangles do not fit it any more stands for its seed alone.
        for (Index p = 0; p < proxies_.size(); ++p)
            if (!(best[p] < HUGE_VAL))
                proxies_[p].axis = faces_[proxies_[p].seed].normal,
                proxies_[p].center = faces_[proxies_[p].seed].center;
    }

    // --- charts as lists of triangles ----------------------------------------------------------
    struct Chart {
        std::vector<Index> triangles;  // ascending
        FlatCorners corners;           // of each of them
    };

    // All charts that the proxies stand for; those that cannot be laid out are cut in two until
    // they can.
    void lay_out_all() {
        std::vector<std::vector<Index>> todo = connected_parts();
        while (!todo.empty()) {
            check_cancelled(context_);
            const std::vector<Index> part = std::move(todo.back());
            todo.pop_back();
            std::pair<Index, Index> apart{part.front(), part.back()};
            std::optional<Chart> chart =
                part.size() > 1 ? lay_out(part, {}, apart) : single(part.front());
            if (chart) {
                for (const Index t : part) chart_of_[t] = static_cast<Index>(charts_.size());
                charts_.push_back(std::move(*chart));
            } else {
                for (std::vector<Index>& half : cut(part, apart)) todo.push_back(std::move(half));
            }
        }
    }

    // A triangle in its own plane; without an area it lies on a line.
    Chart single(Index t) const {
        const bool has_area = faces_[t].area > 0.0;
        const Plane plane = plane_of(has_area ? faces_[t].normal : Vec3d{0.0, 0.0, 1.0});
        return {{t}, {project(plane, t)}};
    }

    // What is connected on one chart. Straightening may cut a part off.
    std::vector<std::vector<Index>> connected_parts() const {
        std::vector<std::vector<Index>> out;
        std::vector<std::uint8_t> seen(faces_.size(), 0);
        for (Index start = 0; start < faces_.size(); ++start) {
            if (seen[start]) continue;
            std::vector<Index> part{start};
            seen[start] = 1;
            for (std::size_t head = 0; head < part.size(); ++head)
                for (const Index next : neighbors_[part[head]])
                    if (next != kInvalidIndex && !seen[next] && chart_of_[next] == chart_of_[start])
                        seen[next] = 1, part.push_back(next);
            std::sort(part.begin(), part.end());
            out.push_back(std::move(part));
        }
        return out;
    }

    // Both parts together in one plane; if that cannot be, `apart` is given two triangles that
    // should not be on one chart.
    std::optional<Chart> lay_out(std::span<const Index> a, std::span<const Index> b,
                                 std::pair<Index, Index>& apart) const {
        Chart out;
        std::merge(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(out.triangles));
        const Vec3d axis = common_axis(out.triangles, apart);
        if (!(squared_length(axis) > 0.0)) return std::nullopt;
        const Plane plane = plane_of(axis);
        for (const Index t : out.triangles) out.corners.push_back(project(plane, t));
        std::optional<FlatCorners> flat = flatten(mesh_, out.triangles, std::move(out.corners));
        if (!flat) return std::nullopt;
        out.corners = std::move(*flat);
        const auto overlap = find_overlap(mesh_, neighbors_, out.triangles, out.corners);
        if (!overlap) return out;
        apart = *overlap;
        return std::nullopt;
    }

    // An axis that all of them fit: towards the normal that is farthest off, by smaller and smaller
    // steps [Badoiu03]. Zero if there is none. `apart`: the two normals that are farthest off, one
    // from the axis, the other from the first.
    Vec3d common_axis(std::span<const Index> triangles, std::pair<Index, Index>& apart) const {
        Vec3d axis;
        for (const Index t : triangles) axis += faces_[t].normal * faces_[t].area;
        axis = normalized(axis);
        if (!(squared_length(axis) > 0.0)) axis = {0.0, 0.0, 1.0};
        for (int step = 1; step <= kConeSteps; ++step) {
            const Index farthest = farthest_from(axis, triangles);
            apart = {farthest, farthest_from(faces_[farthest].normal, triangles)};
            const Vec3d normal = faces_[farthest].normal;
            if (!(faces_[farthest].area > 0.0) || dot(normal, axis) >= kLeastMergedCosine)
                return axis;
            axis = normalized(axis + (normal - axis) / (step + 1.0));
        }
        return {};
    }

    Index farthest_from(Vec3d axis, std::span<const Index> triangles) const {
        Index out = triangles[0];
        double least = 2.0;
        for (const Index t : triangles) {
            if (!(faces_[t].area > 0.0)) continue;
            const double cosine = dot(faces_[t].normal, axis);
            if (cosine < least) least = cosine, out = t;
        }
        return out;
    }

    std::array<Vec2d, 3> project(const Plane& plane, Index t) const {
        const Triangle& tri = mesh_.triangles[t];
        return {plane.place(mesh_.positions[tri[0]]), plane.place(mesh_.positions[tri[1]]),
                plane.place(mesh_.positions[tri[2]])};
    }

    // Halves: what is nearer, over edges, to one of the two triangles than to the other.
    std::vector<std::vector<Index>> cut(std::span<const Index> part,
                                        std::pair<Index, Index> apart) {
        if (apart.first == apart.second) apart = {part.front(), part.back()};  // all face one way
        constexpr Index kPending = kInvalidIndex - 1, kFirst = kInvalidIndex - 2,
                        kSecond = kInvalidIndex - 3;
        for (const Index t : part) chart_of_[t] = kPending;
        chart_of_[apart.first] = kFirst;
        chart_of_[apart.second] = kSecond;
        std::vector<Index> queue{apart.first, apart.second};
        for (std::size_t head = 0; head < queue.size(); ++head)
            for (const Index next : neighbors_[queue[head]])
                if (next != kInvalidIndex && chart_of_[next] == kPending)
                    chart_of_[next] = chart_of_[queue[head]], queue.push_back(next);
        std::vector<std::vector<Index>> out(2);
        for (const Index t : part) out[chart_of_[t] == kFirst ? 0 : 1].push_back(t);
        return out;
    }

    // --- merging -------------------------------------------------------------------------------
    using Pair = std::pair<Index, Index>;

    // Neighbouring charts become one where they can be laid out together, those with the longest
    // common border for their size first, until no pair is left that was not tried.
    void merge_all() {
        bool merged = true;
        std::map<Pair, std::pair<std::size_t, std::size_t>> tried;  // with the sizes then
        while (merged) {
            merged = false;
            for (const Pair& pair : pairs_by_border()) {
                check_cancelled(context_);
                Chart& a = charts_[pair.first];
                Chart& b = charts_[pair.second];
                if (a.triangles.empty() || b.triangles.empty()) continue;
                const std::pair sizes{a.triangles.size(), b.triangles.size()};
                const auto before = tried.find(pair);
                if (before != tried.end() && before->second == sizes) continue;
                tried[pair] = sizes;
                std::pair<Index, Index> apart;
                std::optional<Chart> both = lay_out(a.triangles, b.triangles, apart);
                if (!both || !is_full_enough(a, b, *both)) continue;
                for (const Index t : b.triangles) chart_of_[t] = pair.first;
                a = std::move(*both);
                b = {};
                merged = true;
            }
        }
    }

    // How much of the smallest box around it a chart fills: charts that fill little pack badly.
    double fullness(const Chart& chart) const {
        std::vector<Vec2d> points;
        double area = 0.0;
        for (const auto& c : chart.corners) {
            points.insert(points.end(), c.begin(), c.end());
            area += 0.5 * cross(c[1] - c[0], c[2] - c[0]);
        }
        const double box = least_box(points).area();
        return box > 0.0 ? area / box : 1.0;
    }

    bool is_full_enough(const Chart& a, const Chart& b, const Chart& both) const {
        const double full = fullness(both);
        return full >= kFullEnough || full >= std::min(fullness(a), fullness(b));
    }

    std::vector<Pair> pairs_by_border() const {
        std::map<Pair, double> borders;
        std::vector<double> around(charts_.size(), 0.0);
        for (Index t = 0; t < faces_.size(); ++t)
            for (std::size_t k = 0; k < 3; ++k) {
                const Index next = neighbors_[t][k];
                const double l = edge_length(t, k);
                if (next != kInvalidIndex && chart_of_[next] == chart_of_[t]) continue;
                around[chart_of_[t]] += l;
                if (next != kInvalidIndex && chart_of_[t] < chart_of_[next])
                    borders[{chart_of_[t], chart_of_[next]}] += l;
            }
        std::vector<std::pair<double, Pair>> sorted;
        for (const auto& [pair, l] : borders)
            sorted.push_back({-l / std::min(around[pair.first], around[pair.second]), pair});
        std::sort(sorted.begin(), sorted.end());
        std::vector<Pair> out;
        for (const auto& [key, pair] : sorted) out.push_back(pair);
        return out;
    }

    Charts result() const {
        Charts out;
        out.of_triangle.resize(faces_.size());
        out.corners.resize(faces_.size());
        for (const Chart& chart : charts_) {
            if (chart.triangles.empty()) continue;
            for (std::size_t i = 0; i < chart.triangles.size(); ++i) {
                out.of_triangle[chart.triangles[i]] = out.count;
                out.corners[chart.triangles[i]] = chart.corners[i];
            }
            ++out.count;
        }
        return out;
    }

    const Mesh& mesh_;
    std::span<const std::array<Index, 3>> neighbors_;
    const Context& context_;
    std::vector<Face> faces_;
    std::vector<Proxy> proxies_;
    std::vector<Index> chart_of_;  // per triangle
    std::vector<Chart> charts_;    // emptied where merged into another
};

}  // namespace

Charts grow_charts(const Mesh& mesh, std::span<const std::array<Index, 3>> neighbors,
                   const Context& context) {
    return Grower(mesh, neighbors, context).run();
}

}  // namespace pointbake
