#include "texture/local_field.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/hash.h"

namespace pointbake {
namespace {

constexpr std::size_t kMaxUnfolded =
    384;                             // triangles unfolded around one: a limit for very fine meshes
constexpr float kMinWeight = 1e-5F;  // below, a place counts as not covered
constexpr int kMaxCells = 64;        // per side of the bin grid
// An unfolded splat is dropped if it seems nearer to the triangle than this share of what it is.
constexpr double kLeastDistance = 0.95;
constexpr double kRounding =
    1e-5;  // of the triangle's base: places on its border are single floats

}  // namespace

std::size_t LocalField::Seen::slot_of(Index triangle) const {
    std::size_t slot = hash64(triangle) % kSlots;
    while (slots_[slot] != kInvalidIndex && slots_[slot] != triangle) slot = (slot + 1) % kSlots;
    return slot;
}

bool LocalField::Seen::contains(Index triangle) const {
    return slots_[slot_of(triangle)] == triangle;
}

void LocalField::Seen::insert(Index triangle) {
    const std::size_t slot = slot_of(triangle);
    slots_[slot] = triangle;
    used_.push_back(slot);
}

void LocalField::Seen::clear() {
    for (std::size_t slot : used_) slots_[slot] = kInvalidIndex;
    used_.clear();
}

void LocalField::gather(Index triangle, double border, float widen) {
    triangle_ = triangle;
    widen_ = widen;
    splats_.clear();
    inverses_.clear();
    unfold(triangle, border + static_cast<double>(widen * scene_.prints.reach[triangle]));
    for (const Unfolded& u : queue_) add_splats(u, border);
    build_bins();
}

// The neighbour across edge k of an unfolded triangle, laid beside it: the shared edge in both
// frames gives the rotation and the shift.
std::optional<LocalField::Unfolded> LocalField::unfold_across(const Unfolded& at, std::size_t k,
                                                              Index next) const {
    const Triangle& tri = scene_.mesh.triangles[next];
    const Index a_vertex = scene_.mesh.triangles[at.triangle][k];
    const std::size_t ka = tri[0] == a_vertex ? 0 : (tri[1] == a_vertex ? 1 : 2);
    const TriangleFrame& from = scene_.shell.frame(at.triangle);
    const TriangleFrame& to = scene_.shell.frame(next);
    const Vec2d a = at.place(from.corners[k]), d = at.place(from.corners[(k + 1) % 3]) - a;
    const Vec2d a1 = to.corners[ka], e = to.corners[(ka + 2) % 3] - a1;
    const double norm = length(d) * length(e);
    if (!(norm > 0.0)) return std::nullopt;
    Unfolded u{next, at.root, dot(e, d) / norm, cross(e, d) / norm, 0.0, 0.0};
    u.tx = a.x - (u.c * a1.x - u.s * a1.y);
    u.ty = a.y - (u.s * a1.x + u.c * a1.y);
    return u;
}

// Whether an unfolded triangle comes within `reach` of the edge of the home triangle that the way
// to it leaves through: around its ends, ways would else go on behind the home triangle.
bool LocalField::is_near_root(const Unfolded& u, double reach) const {
    const RootEdge& root = roots_[u.root];
    double nearest = HUGE_VAL, farthest = -HUGE_VAL, first = HUGE_VAL, last = -HUGE_VAL;
    for (const Vec2d& corner : scene_.shell.frame(u.triangle).corners) {
        const Vec2d d = u.place(corner) - root.start;
        nearest = std::min(nearest, dot(d, root.outward));
        farthest = std::max(farthest, dot(d, root.outward));
        first = std::min(first, dot(d, root.along));
        last = std::max(last, dot(d, root.along));
    }
    return farthest >= -reach && nearest <= reach && last >= -reach && first <= root.length + reach;
}

// Breadth first over edges; each triangle is unfolded once, along the first way found. A way stays
// near the edge it leaves the home triangle through.
void LocalField::unfold(Index triangle, double reach) {
    const TriangleFrame& home = scene_.shell.frame(triangle);
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec2d a = home.corners[k], d = home.corners[(k + 1) % 3] - a;
        const double l = length(d);
        const Vec2d along = l > 0.0 ? d / l : Vec2d{1.0, 0.0};
        roots_[k] = {a, along, {along.y, -along.x}, l};
    }
    queue_.clear();
    seen_.clear();
    seen_.insert(triangle);
    queue_.push_back({triangle, kHome, 1.0, 0.0, 0.0, 0.0});
    for (std::size_t head = 0; head < queue_.size() && queue_.size() < kMaxUnfolded; ++head) {
        const Unfolded at = queue_[head];
        for (std::size_t k = 0; k < 3; ++k) {
            const Index next = scene_.neighbors[at.triangle][k];
            if (next == kInvalidIndex || seen_.contains(next)) continue;
            std::optional<Unfolded> u = unfold_across(at, k, next);
            if (!u) continue;
            if (at.root == kHome) u->root = k;
            if (!is_near_root(*u, reach)) continue;
            seen_.insert(next);
            queue_.push_back(*u);
        }
    }
}

// The place of the home triangle that is nearest to x: x itself if it lies over the triangle.
Vec2d LocalField::nearest_home(Vec2d x) const {
    Vec2d nearest = x;
    double best = HUGE_VAL;
    for (const RootEdge& edge : roots_) {
        if (dot(x - edge.start, edge.outward) <= 0.0) continue;
        const double t = std::clamp(dot(x - edge.start, edge.along), 0.0, edge.length);
        const Vec2d y = edge.start + edge.along * t;
        const double distance = length(x - y);
        if (distance < best) best = distance, nearest = y;
    }
    return nearest;
}

// Whether a place lies on the far side of an edge of the home triangle. Nothing there that belongs
// to the triangle across is nearer in space than it is here, where it is laid flat.
bool LocalField::is_beyond(std::size_t edge, Vec2f x) const {
    return dot(vec_cast<double>(x) - roots_[edge].start, roots_[edge].outward) >= 0.0;
}

// Whether the unfolding holds for a splat, given its center in its own triangle and here. A way
// over the surface is never shorter than the straight one through space: where it is, the
// unfolding went around a corner and came back beside the home triangle.
bool LocalField::is_placed(const Unfolded& from, Vec2f own, Vec2f here) const {
    const Vec2d x = vec_cast<double>(here), home = nearest_home(x);
    const double distance = length(x - home);
    const TriangleFrame& theirs = scene_.shell.frame(from.triangle);
    const TriangleFrame& ours = scene_.shell.frame(triangle_);
    return distance + kRounding * ours.base() >=
           kLeastDistance * length(theirs.place(vec_cast<double>(own)) - ours.place(home));
}

void LocalField::add_splats(const Unfolded& from, double border) {
    const TriangleFrame& home = scene_.shell.frame(triangle_);
    const auto c = static_cast<float>(from.c), s = static_cast<float>(from.s);
    const auto tx = static_cast<float>(from.tx), ty = static_cast<float>(from.ty);
    const auto grow = static_cast<float>(border);
    const float width = static_cast<float>(home.base()) + grow,
                height = static_cast<float>(home.height()) + grow;
    const float far = widen_ * scene_.prints.reach[triangle_];  // the largest splat around here
    const bool is_next =
        from.root != kHome && scene_.neighbors[triangle_][from.root] == from.triangle;
    const Index first = scene_.prints.begin[from.triangle];
    const std::span<const Footprint> prints = scene_.prints.of(from.triangle);
    for (std::size_t i = 0; i < prints.size(); ++i) {
        const Footprint& f = prints[i];
        if (f.hidden) continue;
        LocalSplat out;
        out.center = {c * f.center.x - s * f.center.y + tx, s * f.center.x + c * f.center.y + ty};
        if (out.center.x < -grow - far || out.center.x > width + far ||
            out.center.y < -grow - far || out.center.y > height + far)
            continue;
        out.vxx = c * c * f.vxx - 2.0F * c * s * f.vxy + s * s * f.vyy;
        out.vyy = s * s * f.vxx + 2.0F * c * s * f.vxy + c * c * f.vyy;
        out.vxy = c * s * (f.vxx - f.vyy) + (c * c - s * s) * f.vxy;
        out.item = first + static_cast<Index>(i);
        const float rx = scene_.kernel.cut * std::sqrt(out.vxx),
                    ry = scene_.kernel.cut * std::sqrt(out.vyy);
        const float wide_x = widen_ * rx, wide_y = widen_ * ry;
        if (out.center.x + wide_x < -grow || out.center.x - wide_x > width) continue;
        if (out.center.y + wide_y < -grow || out.center.y - wide_y > height) continue;
        const float det = out.vxx * out.vyy - out.vxy * out.vxy;
        if (!(det > 0.0F)) continue;
        if (from.root != kHome && !(is_next && is_beyond(from.root, out.center)) &&
            !is_placed(from, f.center, out.center))
            continue;
        splats_.push_back(out);
        inverses_.push_back({out.vyy / det, -out.vxy / det, out.vxx / det, rx, ry});
    }
}

void LocalField::build_bins() {
    const TriangleFrame& home = scene_.shell.frame(triangle_);
    const auto reach = static_cast<float>(scene_.prints.reach[triangle_]);
    const auto w = static_cast<float>(home.base()), h = static_cast<float>(home.height());
    grid_origin_ = {0.0F, 0.0F};
    const float cell = std::max({0.5F * reach, w / kMaxCells, h / kMaxCells, 1e-30F});
    cells_per_unit_ = 1.0F / cell;
    grid_width_ = std::clamp(static_cast<int>(w * cells_per_unit_) + 1, 1, kMaxCells);
    grid_height_ = std::clamp(static_cast<int>(h * cells_per_unit_) + 1, 1, kMaxCells);
    const auto range = [&](std::size_t i, auto&& visit) {
        const LocalSplat& s = splats_[i];
        const auto cell_of = [&](float at, int n) {
            return static_cast<int>(
                std::clamp(at * cells_per_unit_, 0.0F, static_cast<float>(n - 1)));
        };
        const float rx = widen_ * inverses_[i].radius_x, ry = widen_ * inverses_[i].radius_y;
        const int x0 = cell_of(s.center.x - rx, grid_width_),
                  x1 = cell_of(s.center.x + rx, grid_width_);
        const int y0 = cell_of(s.center.y - ry, grid_height_),
                  y1 = cell_of(s.center.y + ry, grid_height_);
        for (int y = y0; y <= y1; ++y) {
            for (int x = x0; x <= x1; ++x) visit(static_cast<std::size_t>(y * grid_width_ + x));
        }
    };
    cell_begin_.assign(static_cast<std::size_t>(grid_width_ * grid_height_) + 1, 0);
    for (std::size_t i = 0; i < splats_.size(); ++i)
        range(i, [&](std::size_t c) { ++cell_begin_[c + 1]; });
    std::partial_sum(cell_begin_.begin(), cell_begin_.end(), cell_begin_.begin());
    cell_items_.resize(cell_begin_.back());
    for (std::size_t i = splats_.size(); i-- > 0;) {
        range(i, [&](std::size_t c) { cell_items_[--cell_begin_[c + 1]] = static_cast<Index>(i); });
    }
    // Filling backwards left each begin one cell late.
    for (std::size_t c = 0; c + 1 < cell_begin_.size(); ++c) cell_begin_[c] = cell_begin_[c + 1];
    cell_begin_.back() = static_cast<Index>(cell_items_.size());
}

std::size_t LocalField::cell_at(Vec2f x) const {
    const int cx = std::clamp(static_cast<int>(x.x * cells_per_unit_), 0, grid_width_ - 1);
    const int cy = std::clamp(static_cast<int>(x.y * cells_per_unit_), 0, grid_height_ - 1);
    return static_cast<std::size_t>(cy * grid_width_ + cx);
}

SplatSum LocalField::evaluate(Vec2f x, std::span<const Vec3f> values) const {
    SplatSum out;
    for_each_weight(x, [&](Index item, float w) {
        out.sum += values[item] * w;
        out.weight += w;
    });
    return out.weight > kMinWeight ? out : evaluate_wide(x, values);
}

// Of kernels so much wider. Cells know what reaches them at the width of gather().
template <class Visit>
void LocalField::for_each_wide_weight(Vec2f x, float widen, Visit&& visit) const {
    const auto look_at = [&](Index i) {
        const float q = squared_radius(x, i) / (widen * widen);
        if (q < scene_.kernel.cut2) visit(splats_[i].item, scene_.kernel(q));
    };
    if (widen > widen_) {
        for (Index i = 0; i < splats_.size(); ++i) look_at(i);
        return;
    }
    const std::size_t cell = cell_at(x);
    for (Index k = cell_begin_[cell]; k < cell_begin_[cell + 1]; ++k) look_at(cell_items_[k]);
}

bool LocalField::is_covered(Vec2f x) const {
    float sum = 0.0F;
    for_each_wide_weight(x, widen_, [&](Index /*item*/, float w) { sum += w; });
    return sum > kMinWeight;
}

SplatSum LocalField::evaluate_wide(Vec2f x, std::span<const Vec3f> values) const {
    constexpr float kWidest = 1024.0F;  // reaches anything gathered
    for (float widen = 2.0F; widen <= kWidest; widen *= 2.0F) {
        SplatSum out;
        for_each_wide_weight(x, widen, [&](Index item, float w) {
            out.sum += values[item] * w;
            out.weight += w;
        });
        if (out.weight > kMinWeight) return out;
    }
    return {};
}

}  // namespace pointbake
