// Mesh optimisation in the spirit of [Hoppe93]: alternately, points go to their nearest triangle,
// and vertices to the place where the sum of squared distances is least; edges flip where that
// lowers the sum. Departs from it: one vertex at a time by a damped Gauss-Newton step, no springs.
#include "simplify/fit.h"

#include <algorithm>
#include <numeric>

#include "core/adjacency.h"
#include "core/parallel.h"
#include "simplify/quadric.h"

namespace pointbake {
namespace {

constexpr std::size_t kPointGrain = 2048;
constexpr std::size_t kTriangleGrain = 512;
constexpr std::size_t kVertexGrain = 64;
// Rounds of attribution; the sum falls by less than a percent in a later one.
constexpr int kNumRounds = 8;
constexpr int kNumFlipRounds = 4;
constexpr int kSweepsPerRound = 2;
// Pull towards the present place, as a share of the mean eigenvalue: directions that the points do
// not determine stay.
constexpr double kStepPull = 0.02;
// Of a triangle's normal before and after a step: 45 degrees.
constexpr double kMinTurnCosine = 0.7;
// Across an edge after a flip: about 75 degrees, unless it was sharper before.
constexpr double kMinFlipCosine = 0.25;
// Triangles worse than this may only improve.
constexpr double kMinQuality = 0.05;
// A flip must gain this share of what its points contribute; less is rounding and noise.
constexpr double kMinFlipGain = 1e-3;
// A vertex may be this many point spacings from the nearest point of its ring.
constexpr double kReach = 1.0;
constexpr int kMaxWalk = 16;

struct PointsByTriangle {
    std::vector<Index> begin, items;
    std::span<const Index> of(Index t) const {
        return std::span(items).subspan(begin[t], begin[t + 1] - begin[t]);
    }
};

PointsByTriangle sort_by_owner(const std::vector<Index>& owners, std::size_t num_triangles) {
    PointsByTriangle out;
    out.begin.assign(num_triangles + 1, 0);
    for (Index t : owners) {
        if (t != kInvalidIndex) ++out.begin[t + 1];
    }
    std::partial_sum(out.begin.begin(), out.begin.end(), out.begin.begin());
    out.items.resize(out.begin.back());
    std::vector<Index> next(out.begin.begin(), out.begin.end() - 1);
    for (Index p = 0; p < owners.size(); ++p) {
        if (owners[p] != kInvalidIndex) out.items[next[owners[p]]++] = p;
    }
    return out;
}

class Fitter {
 public:
    Fitter(FitMesh& mesh, const Attribution& points, double squared_limit, const Context& context)
        : mesh_(mesh), points_(points), limit_(squared_limit), context_(context) {
        rings_ = vertex_triangles(mesh_.positions.size(), mesh_.triangles);
        make_frames();
    }

    void run() {
        for (int round = 0; round < kNumRounds; ++round) {
            walk(false);
            by_triangle_ = sort_by_owner(mesh_.owners, mesh_.triangles.size());
            for (int sweep = 0; sweep < kSweepsPerRound; ++sweep) {
                improve_vertices();
            }
            if (round < kNumFlipRounds) flip_edges();
        }
        walk(true);
    }

    void walk(bool is_thorough);

 private:
    FaceFrame frame_of(const Triangle& t) const {
        return {mesh_.positions[t[0]], mesh_.positions[t[1]], mesh_.positions[t[2]]};
    }
    void make_frames() {
        frames_.resize(mesh_.triangles.size());
        parallel_for(context_, frames_.size(), kTriangleGrain,
                     [&](std::size_t begin, std::size_t end) {
                         for (std::size_t t = begin; t < end; ++t)
                             frames_[t] = frame_of(mesh_.triangles[t]);
                     });
    }
    struct Step {
        Vec3d step;
        double error = 0.0;  // of the ring, before it
    };
    Step step(Index v) const;
    double ring_error(Index v, const std::vector<FaceFrame>& frames, double give_up_above) const;
    bool is_near_data(Index v, Vec3d place) const;
    bool try_place(Index v, Vec3d place, double error_before, std::vector<FaceFrame>& ring);
    void improve_vertex(Index v, std::vector<FaceFrame>& ring);
    void improve_vertices();
    std::vector<std::vector<Index>> color_vertices() const;

    struct Flip {
        double gain;
        Index triangle, edge;
    };
    double flip_gain(Index t, Index k, const std::vector<std::array<Index, 3>>& neighbors,
                     std::array<Triangle, 2>* flipped) const;
    bool are_joined(Index c, Index d) const;
    void apply_flip(Index t, Index s, const std::array<Triangle, 2>& flipped);
    void flip_edges();

    FitMesh& mesh_;
    const Attribution& points_;
    double limit_;
    const Context& context_;
    VertexTriangles rings_;
    PointsByTriangle by_triangle_;
    std::vector<FaceFrame> frames_;
};

// Unless thorough, a point above its triangle stays there: another one can be nearer only across a
// fold.
void Fitter::walk(bool is_thorough) {
    parallel_for(
        context_, mesh_.owners.size(), kPointGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t p = begin; p < end; ++p) {
                Index& owner = mesh_.owners[p];
                if (owner == kInvalidIndex) continue;
                const Vec3d x = points_.points[p], n = vec_cast<double>(points_.normals[p]);
                double best = frames_[owner].squared_distance(x, HUGE_VAL);
                if (!is_thorough && best == frames_[owner].squared_height(x)) continue;
                const bool is_askew = dot(n, frames_[owner].normal) <= 0.0;
                for (int i = 0; i < kMaxWalk; ++i) {
                    const Index from = owner;
                    for (Index v : mesh_.triangles[from]) {
                        for (Index t : rings_.of(v)) {
                            const double d = frames_[t].squared_distance(x, best);
                            // The far side of a thin sheet may be nearer, but it is not the
                            // point's.
                            if (d < best && (is_askew || dot(n, frames_[t].normal) > 0.0))
                                best = d, owner = t;
                        }
                    }
                    if (owner == from) break;
                }
            }
        });
}

// The Gauss-Newton step of one vertex: each point of its ring asks for its residual, scaled by the
// barycentric weight that the vertex has at the point's foot.
Fitter::Step Fitter::step(Index v) const {
    Quadric q;  // of the step
    Step out;
    for (Index t : rings_.of(v)) {
        const FaceFrame& frame = frames_[t];
        const Triangle& corners = mesh_.triangles[t];
        const std::size_t k = corners[0] == v ? 0 : (corners[1] == v ? 1 : 2);
        for (Index p : by_triangle_.of(t)) {
            const ClosestFoot foot = frame.foot(points_.points[p]);
            const double b = foot.barycentric[k];
            const double w = points_.weights[p];
            out.error += w * foot.residual * foot.residual;
            if (!(b > 0.0)) continue;
            // (b u . d - r)^2 with direction u and residual r, as the plane u . d = r / b.
            q.add_plane(foot.direction, foot.direction * (foot.residual / b), w * b * b);
        }
    }
    const double trace = q.trace();
    if (trace > 0.0) out.step = q.minimum_near(Vec3d{}, kStepPull / 3.0 * trace, 1);
    return out;
}

double Fitter::ring_error(Index v, const std::vector<FaceFrame>& frames,
                          double give_up_above) const {
    double sum = 0.0;
    std::size_t i = 0;
    for (Index t : rings_.of(v)) {
        const FaceFrame& frame = frames[i++];
        for (Index p : by_triangle_.of(t)) {
            const double d = frame.squared_distance(points_.points[p], HUGE_VAL);
            if (d > limit_) return HUGE_VAL;
            sum += points_.weights[p] * d;
        }
        if (sum > give_up_above) return HUGE_VAL;
    }
    return sum;
}

// Points do not feel a vertex that runs away from all of them: it stays within reach of one.
bool Fitter::is_near_data(Index v, Vec3d place) const {
    double nearest_before = HUGE_VAL, nearest_after = HUGE_VAL, area = 0.0;
    std::size_t count = 0;
    for (Index t : rings_.of(v)) {
        for (Index p : by_triangle_.of(t)) {
            const Vec3d x = points_.points[p];
            nearest_before = std::min(nearest_before, squared_length(x - mesh_.positions[v]));
            nearest_after = std::min(nearest_after, squared_length(x - place));
            area += points_.weights[p];
            ++count;
        }
    }
    const double reach = kReach * kReach * area / static_cast<double>(count);
    return nearest_after <= std::max(reach, nearest_before);
}

bool Fitter::try_place(Index v, Vec3d place, double error_before, std::vector<FaceFrame>& ring) {
    ring.clear();
    for (Index t : rings_.of(v)) {
        const FaceFrame& before = frames_[t];
        const Triangle& corners = mesh_.triangles[t];
        std::array<Vec3d, 3> x = before.corners;
        x[corners[0] == v ? 0 : (corners[1] == v ? 1 : 2)] = place;
        const FaceFrame after(x[0], x[1], x[2]);
        if (after.is_flat() || dot(before.normal, after.normal) < kMinTurnCosine) return false;
        const double quality = after.quality();
        if (quality < kMinQuality && quality < before.quality()) return false;
        ring.push_back(after);
    }
    if (!(ring_error(v, ring, error_before) < error_before)) return false;
    if (!is_near_data(v, place)) return false;
    mesh_.positions[v] = place;
    std::size_t i = 0;
    for (Index t : rings_.of(v)) frames_[t] = ring[i++];
    return true;
}

void Fitter::improve_vertex(Index v, std::vector<FaceFrame>& ring) {
    if (mesh_.kinds[v] == VertexKind::kFixed) return;
    auto [d, before] = step(v);
    // Points tell where a surface is, not where it ends: a border moves along the normal alone.
    if (mesh_.kinds[v] == VertexKind::kCurve) {
        Vec3d normal;
        for (Index t : rings_.of(v)) normal += frames_[t].normal;
        normal = normalized(normal);
        d = normal * dot(normal, d);
    }
    if (!is_finite(d) || d == Vec3d{}) return;
    const Vec3d from = mesh_.positions[v];
    for (double share : {1.0, 0.5}) {
        if (try_place(v, from + d * share, before, ring)) return;
    }
}

// Vertices in groups without an edge inside: those of one group do not feel each other.
std::vector<std::vector<Index>> Fitter::color_vertices() const {
    std::vector<std::vector<Index>> groups;
    std::vector<std::size_t> colors(mesh_.positions.size(), 0);
    std::vector<std::uint8_t> is_taken;
    for (Index v = 0; v < mesh_.positions.size(); ++v) {
        is_taken.assign(groups.size() + 1, 0);
        for (Index t : rings_.of(v)) {
            for (Index w : mesh_.triangles[t]) {
                if (w < v) is_taken[colors[w]] = 1;
            }
        }
        while (is_taken[colors[v]]) ++colors[v];
        if (colors[v] == groups.size()) groups.emplace_back();
        groups[colors[v]].push_back(v);
    }
    return groups;
}

void Fitter::improve_vertices() {
    for (const std::vector<Index>& group : color_vertices()) {
        parallel_for(context_, group.size(), kVertexGrain, [&](std::size_t begin, std::size_t end) {
            std::vector<FaceFrame> ring;
            for (std::size_t i = begin; i < end; ++i) improve_vertex(group[i], ring);
        });
    }
}

bool Fitter::are_joined(Index c, Index d) const {
    for (Index t : rings_.of(c)) {
        for (Index v : mesh_.triangles[t]) {
            if (v == d) return true;
        }
    }
    return false;
}

// Gain of turning edge k of triangle t within the quadrilateral of its two triangles; 0 if that is
// not allowed.
double Fitter::flip_gain(Index t, Index k, const std::vector<std::array<Index, 3>>& neighbors,
                         std::array<Triangle, 2>* flipped) const {
    const Index s = neighbors[t][k];
    if (s == kInvalidIndex || s < t) return 0.0;
    const Triangle& vt = mesh_.triangles[t];
    const Index a = vt[k], b = vt[(k + 1) % 3], c = vt[(k + 2) % 3];
    Index d = kInvalidIndex;
    for (Index v : mesh_.triangles[s]) {
        if (v != a && v != b) d = v;
    }
    if (c == d || are_joined(c, d)) return 0.0;
    const Triangle first{a, d, c}, second{d, b, c};
    const FaceFrame f1 = frame_of(first), f2 = frame_of(second);
    if (f1.is_flat() || f2.is_flat()) return 0.0;
    const FaceFrame &g1 = frames_[t], &g2 = frames_[s];
    const double old_fold = dot(g1.normal, g2.normal), new_fold = dot(f1.normal, f2.normal);
    if (new_fold < kMinFlipCosine && new_fold < old_fold) return 0.0;
    for (const FaceFrame* f : {&f1, &f2}) {
        if (dot(f->normal, g1.normal) < kMinFlipCosine &&
            dot(f->normal, g2.normal) < kMinFlipCosine)
            return 0.0;
    }
    const double new_quality = std::min(f1.quality(), f2.quality());
    if (new_quality < kMinQuality && new_quality < std::min(g1.quality(), g2.quality())) return 0.0;
    double before = 0.0, after = 0.0;
    for (Index f : {t, s}) {
        for (Index p : by_triangle_.of(f)) {
            const Vec3d x = points_.points[p];
            const double w = points_.weights[p];
            const double old1 = g1.squared_distance(x, HUGE_VAL),
                         old2 = g2.squared_distance(x, old1);
            const double new1 = f1.squared_distance(x, HUGE_VAL),
                         new2 = f2.squared_distance(x, new1);
            const double new_best = std::min(new1, new2);
            if (new_best > limit_) return 0.0;
            before += w * std::min(old1, old2);
            after += w * new_best;
        }
    }
    if (flipped) *flipped = {first, second};
    return before - after > kMinFlipGain * before ? before - after : 0.0;
}

void Fitter::apply_flip(Index t, Index s, const std::array<Triangle, 2>& flipped) {
    mesh_.triangles[t] = flipped[0];
    mesh_.triangles[s] = flipped[1];
    frames_[t] = frame_of(flipped[0]);
    frames_[s] = frame_of(flipped[1]);
    for (Index f : {t, s}) {
        for (Index p : by_triangle_.of(f)) {
            const double d = frames_[t].squared_distance(points_.points[p], HUGE_VAL);
            mesh_.owners[p] = frames_[s].squared_distance(points_.points[p], d) < d ? s : t;
        }
    }
}

void Fitter::flip_edges() {
    const auto neighbors = triangle_neighbors(mesh_.triangles);
    const std::size_t n = mesh_.triangles.size();
    walk(false);
    by_triangle_ = sort_by_owner(mesh_.owners, n);
    std::vector<std::array<double, 3>> gains(n);
    parallel_for(context_, n, kTriangleGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t t = begin; t < end; ++t) {
            for (Index k = 0; k < 3; ++k)
                gains[t][k] = flip_gain(static_cast<Index>(t), k, neighbors, nullptr);
        }
    });
    std::vector<Flip> flips;
    for (Index t = 0; t < n; ++t) {
        for (Index k = 0; k < 3; ++k) {
            if (gains[t][k] > 0.0) flips.push_back({gains[t][k], t, k});
        }
    }
    std::sort(flips.begin(), flips.end(), [](const Flip& x, const Flip& y) {
        if (x.gain != y.gain) return x.gain > y.gain;
        return x.triangle != y.triangle ? x.triangle < y.triangle : x.edge < y.edge;
    });
    // Two flips that share a vertex would not see each other's triangles: the better one goes.
    std::vector<bool> is_taken(mesh_.positions.size(), false);
    for (const Flip& f : flips) {
        const Index s = neighbors[f.triangle][f.edge];
        bool is_free = true;
        for (Index t : {f.triangle, s}) {
            for (Index v : mesh_.triangles[t]) is_free = is_free && !is_taken[v];
        }
        if (!is_free) continue;
        std::array<Triangle, 2> flipped;
        if (!(flip_gain(f.triangle, f.edge, neighbors, &flipped) > 0.0)) continue;
        apply_flip(f.triangle, s, flipped);
        for (const Triangle& t : flipped) {
            for (Index v : t) is_taken[v] = true;
        }
    }
    rings_ = vertex_triangles(mesh_.positions.size(), mesh_.triangles);
}

}  // namespace

void fit_in_place(FitMesh& mesh, const Attribution& points, double squared_limit,
                  const Context& context) {
    Fitter(mesh, points, squared_limit, context).run();
}

void walk_to_nearest_in_place(FitMesh& mesh, const Attribution& points, const Context& context) {
    Fitter(mesh, points, HUGE_VAL, context).walk(true);
}

}  // namespace pointbake
