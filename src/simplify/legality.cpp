// The link condition follows [Dey99] for surfaces with boundaries and non-manifold curves; the
// attribution test is that of [Klein96]: all points of the two rings stay within the bound.
#include "simplify/legality.h"

#include <algorithm>
#include <cmath>

namespace pointbake {
namespace {

// Of a triangle's normal before and after: about 75 degrees. At 90 degrees a triangle could turn
// over in several steps.
constexpr double kMinFlipCosine = 0.25;
// Of a triangle's normal and the original normal of its points: 60 degrees, so that splats project.
constexpr double kMinConeCosine = 0.5;
// What is beyond that from the start, at sharp edges, must not get worse than by rounding.
constexpr double kConeSlack = 1e-3;
// Triangles worse than this may only improve.
constexpr double kMinQuality = 0.05;

}  // namespace

Verdict CollapseJudge::judge(Index a, Index b, Vec3d target) {
    if (!is_topology_kept(a, b)) return Verdict::kTopology;
    if (!make_new_faces(a, b, target)) return Verdict::kShape;
    if (!is_border_kept(a, b, target)) return Verdict::kBound;
    return reattribute();
}

Index CollapseJudge::apply(Index a, Index b, Vec3d target) {
    for (Index t : removed_faces_) attribution_.first_points[t] = kInvalidIndex;
    for (Index t : kept_faces_) attribution_.first_points[t] = kInvalidIndex;
    for (const Move& m : moves_) attribution_.add(kept_faces_[m.face], m.point);
    if (!border_ends_.is_none()) border_.apply(a, b, border_ends_);
    surface_.collapse(a, b, target);
    return static_cast<Index>(removed_faces_.size());
}

// a and b have no common neighbours but the apexes of the triangles on ab, no triangle comes to lie
// on another one, and no two curves of special edges meet.
bool CollapseJudge::is_topology_kept(Index a, Index b) {
    collect_edges(surface_, a, edges_a_);
    collect_edges(surface_, b, edges_b_);
    const auto ab = std::find_if(edges_a_.begin(), edges_a_.end(),
                                 [&](const EdgeUse& e) { return e.neighbor == b; });
    if (!ab->is_special() && surface_.kinds[a] != VertexKind::kInterior &&
        surface_.kinds[b] != VertexKind::kInterior)
        return false;
    for (const EdgeUse& e : edges_a_) marks_[e.neighbor] = e.is_special() ? 2 : 1;
    int num_common = 0;
    bool is_kept = true;
    for (const EdgeUse& e : edges_b_) {
        const std::uint8_t mark = marks_[e.neighbor];
        num_common += mark != 0 ? 1 : 0;
        if (mark == 2 && e.is_special()) is_kept = false;
    }
    is_kept = is_kept && num_common == ab->num_triangles();
    for (const EdgeUse& e : edges_a_) marks_[e.neighbor] = 0;
    return is_kept && (num_common < 2 || !covers_triangle(a, b));
}

// With all common neighbours apexes, a triangle of a that falls on one of b has two of them.
bool CollapseJudge::covers_triangle(Index a, Index b) {
    for (const EdgeUse& e : edges_b_) marks_[e.neighbor] = 1;
    bool found = false;
    surface_.for_each_corner(a, [&](Index c) {
        const Index v = surface_.after(c), w = surface_.before(c);
        if (v != b && w != b && marks_[v] && marks_[w]) found = true;
    });
    for (const EdgeUse& e : edges_b_) marks_[e.neighbor] = 0;
    return found;
}

// Collects the triangles of both rings and the successors of those that stay; false if one of them
// turns over, degenerates or becomes a needle.
bool CollapseJudge::make_new_faces(Index a, Index b, Vec3d target) {
    removed_faces_.clear();
    kept_faces_.clear();
    new_faces_.clear();
    worst_before_ = worst_after_ = 1.0;
    bool is_fine = true;
    for (Index v : {a, b}) {
        const Index other = v == a ? b : a;
        surface_.for_each_corner(v, [&](Index c) {
            if (surface_.after(c) != other && surface_.before(c) != other)
                is_fine = is_fine && replace_corner(c, target);
            else if (v == a)
                removed_faces_.push_back(c / 3);
        });
    }
    if (!is_fine || new_faces_.empty()) return false;
    return strictness != Strictness::kFull || worst_after_ >= kMinQuality ||
           worst_after_ > worst_before_;
}

bool CollapseJudge::replace_corner(Index corner, Vec3d target) {
    auto x = surface_.corners_of(corner / 3);
    const Vec3d before = cross(x[1] - x[0], x[2] - x[0]);
    worst_before_ = std::min(worst_before_, triangle_quality(x[0], x[1], x[2]));
    x[corner % 3] = target;
    const FaceFrame frame(x[0], x[1], x[2]);
    if (frame.is_flat()) return false;
    worst_after_ = std::min(worst_after_, triangle_quality(x[0], x[1], x[2]));
    // A triangle without area may turn to anywhere.
    const bool is_turned =
        squared_length(before) > 0.0 && dot(before, frame.normal) < kMinFlipCosine * length(before);
    kept_faces_.push_back(corner / 3);
    new_faces_.push_back(frame);
    return !is_turned || strictness == Strictness::kTopologyOnly;
}

bool CollapseJudge::is_border_kept(Index a, Index b, Vec3d target) {
    border_ends_ = {};
    if (!(limit_ < HUGE_VAL)) return true;
    border_ends_ = find_border_ends(a, edges_a_, b, edges_b_);
    return border_ends_.is_none() ||
           border_.is_within(surface_, a, b, border_ends_, target, limit_);
}

// Finds for every point of the old triangles the nearest new one. The points most at risk, those of
// the vanishing triangles, come first.
Verdict CollapseJudge::reattribute() {
    moves_.clear();
    for (const auto* faces : {&removed_faces_, &kept_faces_}) {
        for (Index t : *faces) {
            const Verdict verdict = reattribute(t);
            if (verdict != Verdict::kLegal) return verdict;
        }
    }
    return Verdict::kLegal;
}

// The nearest new face within the bound that does not look too far away from n.
std::uint32_t CollapseJudge::nearest_facing(Vec3d x, Vec3d n, double least_cosine) const {
    double best = limit_;
    std::uint32_t face = kInvalidIndex;
    for (std::uint32_t f = 0; f < new_faces_.size(); ++f) {
        if (dot(n, new_faces_[f].normal) < least_cosine) continue;
        const double d = new_faces_[f].squared_distance(x, best);
        if (d < best) best = d, face = f;
    }
    return face;
}

// Stops at the first point that would be too far or look the wrong way.
Verdict CollapseJudge::reattribute(Index old_face) {
    if (attribution_.first_points[old_face] == kInvalidIndex) return Verdict::kLegal;
    const auto [qa, qb, qc] = surface_.corners_of(old_face);
    const Vec3d old_normal = normalized(cross(qb - qa, qc - qa));
    std::uint32_t guess = 0;
    while (guess < kept_faces_.size() && kept_faces_[guess] != old_face) ++guess;
    const bool is_kept = guess < kept_faces_.size();
    if (!is_kept) guess = 0;
    for (Index p = attribution_.first_points[old_face]; p != kInvalidIndex;
         p = attribution_.next_points[p]) {
        const Vec3d x = attribution_.points[p];
        double best = new_faces_[guess].squared_distance(x, HUGE_VAL);
        std::uint32_t face = guess;
        // Mostly a point stays above the triangle that it was above. Another one may be nearer
        // where the surface folds; that would only lower its distance.
        const bool stays = is_kept && best <= limit_ && best == new_faces_[guess].squared_height(x);
        for (std::uint32_t f = 0; f < new_faces_.size() && !stays; ++f) {
            const double d = new_faces_[f].squared_distance(x, best);
            if (d < best) best = d, face = f;
        }
        if (best > limit_) return Verdict::kBound;
        const Vec3d n = vec_cast<double>(attribution_.normals[p]);
        const double least = std::min(kMinConeCosine, dot(n, old_normal) - kConeSlack);
        if (strictness == Strictness::kFull && dot(n, new_faces_[face].normal) < least) {
            face = nearest_facing(x, n, least);
            if (face == kInvalidIndex) return Verdict::kShape;
        }
        moves_.push_back({p, face});
    }
    return Verdict::kLegal;
}

}  // namespace pointbake
