// Bisection after [Maubach95] from Kuhn's six tetrahedra per cube. Three bisections make eight
// cubes out of one; the diagonals of the small ones all meet in the middle of the large one.
#include "reconstruct/simplex_grid.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/hash.h"

namespace pointbake {
namespace {

constexpr std::size_t kFirstTable = 1U << 12;
// Enough parts for the threads, few enough that each is worth a thread's while.
constexpr std::size_t kSubtrees = 2048;

}  // namespace

SimplexGrid::SimplexGrid(Vec3d corner, double cube_size, std::array<int, 3> num_cubes)
    : corner_(corner), unit_(cube_size / kCubeUnits), num_cubes_(num_cubes), table_(kFirstTable) {
    for (int z = 0; z <= num_cubes[2]; ++z)
        for (int y = 0; y <= num_cubes[1]; ++y)
            for (int x = 0; x <= num_cubes[0]; ++x)
                add({x * kCubeUnits, y * kCubeUnits, z * kCubeUnits});
    num_corners_ = num_nodes();
}

Vec3d SimplexGrid::place(const Point& p) const {
    return {corner_.x + unit_ * p[0], corner_.y + unit_ * p[1], corner_.z + unit_ * p[2]};
}

bool SimplexGrid::is_inside(const Point& p) const {
    for (std::size_t k = 0; k < 3; ++k)
        if (p[k] < 0 || p[k] > num_cubes_[k] * kCubeUnits) return false;
    return true;
}

bool SimplexGrid::is_on_boundary(Index node) const {
    const Point& p = points_[node];
    for (std::size_t k = 0; k < 3; ++k)
        if (p[k] == 0 || p[k] == num_cubes_[k] * kCubeUnits) return true;
    return false;
}

SimplexGrid::Shape SimplexGrid::shape(const Point& p) {
    const auto all = static_cast<std::uint32_t>(p[0] | p[1] | p[2]);
    const std::int32_t half = std::int32_t{1} << std::countr_zero(all);
    std::size_t num_odd = 0, odd = 0, even = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        if (p[k] & half) {
            ++num_odd;
            odd = k;
        } else {
            even = k;
        }
    }
    if (num_odd == 3) return {kCube, half, 0};
    return num_odd == 2 ? Shape{kFace, half, even} : Shape{kEdge, half, odd};
}

/// The diagonal of a cube (face) runs from its corner with even coordinates, counted in its own
/// edge length, to that with odd ones.
SimplexGrid::Point SimplexGrid::edge_end(const Point& p, bool is_odd) {
    const Shape s = shape(p);
    if (s.kind == kEdge) return moved(p, s.axis, is_odd ? s.half : -s.half);
    Point end = p;
    for (std::size_t k = 0; k < 3; ++k) {
        if (s.kind == kFace && k == s.axis) continue;
        // The largest cubes are all alike, not mirrored.
        const bool low_is_odd = 2 * s.half != kCubeUnits && ((p[k] - s.half) & (2 * s.half)) != 0;
        end[k] += low_is_odd == is_odd ? -s.half : s.half;
    }
    return end;
}

std::array<Index, 2> SimplexGrid::edge(const Point& p) const {
    return {find(edge_end(p, false)), find(edge_end(p, true))};
}

double SimplexGrid::edge_length(const Point& p) const {
    const Shape s = shape(p);
    constexpr std::array<double, 3> kLengths{1.7320508075688772, 1.4142135623730951, 1.0};
    return kLengths[s.kind] * 2.0 * s.half * unit_;
}

double SimplexGrid::reach(const Point& p) const {
    const Shape s = shape(p);
    // To the corners of the cube, of the face; from an edge to the middles of the cubes around it.
    constexpr std::array<double, 3> kRadii{0.8660254037844386, 0.7071067811865476,
                                           0.7071067811865476};
    return kRadii[s.kind] * 2.0 * s.half * unit_;
}

double SimplexGrid::reach(const Point& p, Vec3f direction) const {
    const float size = length(direction);
    if (size == 0.0F) return reach(p);
    const Shape s = shape(p);
    Vec3f d = direction / size;
    for (std::size_t k = 0; k < 3; ++k) d[k] = std::abs(d[k]);
    // To a corner of the cube or of the face, to the middle of a cube beside the face; likewise
    // from an edge.
    const float all = d.x + d.y + d.z;
    const float share = s.kind == kCube ? all : std::max(d[s.axis], all - d[s.axis]);
    return double{share} * s.half * unit_;
}

int SimplexGrid::level(Index node) const {
    if (is_corner(node)) return 0;
    const Shape s = shape(points_[node]);
    return 3 * (kDepth - 1 - std::countr_zero(static_cast<std::uint32_t>(s.half))) + s.kind + 1;
}

/// Points that must be nodes before all tetrahedra around this point's edge exist.
template <class Visit>
void SimplexGrid::for_each_parent(const Point& p, Visit&& visit) const {
    const Shape s = shape(p);
    const auto visit_inside = [&](const Point& q) {
        if (is_inside(q)) visit(q);
    };
    if (s.kind == kCube) {
        if (2 * s.half == kCubeUnits) return;
        const Point even = edge_end(p, false);
        for (std::size_t k = 0; k < 3; ++k) visit(moved(even, k, 2 * (p[k] - even[k])));
        return;
    }
    for (std::size_t k = 0; k < 3; ++k) {
        if ((s.kind == kFace) != (k == s.axis)) continue;
        visit_inside(moved(p, k, -s.half));
        visit_inside(moved(p, k, s.half));
    }
}

/// Whether another parent of the child is there to visit it: the first one that may be.
bool SimplexGrid::is_left_to(const Point& child, const Point& parent) const {
    const Shape s = shape(child);
    Point first = child;
    if (s.kind == kCube) {
        if (2 * s.half == kCubeUnits) return false;
        const Point even = edge_end(child, false);
        first = moved(even, 0, 2 * (child[0] - even[0]));
    } else {
        const std::size_t across = s.kind == kFace ? s.axis : (s.axis == 0 ? 1 : 0);
        first = moved(child, across, -s.half);
    }
    return first != parent && is_inside(first) && find(first) != kInvalidIndex;
}

void SimplexGrid::split(const Point& point) {
    std::vector<Point> pending{point};
    while (!pending.empty()) {
        const Point p = pending.back();
        pending.pop_back();
        if (add(p)) for_each_parent(p, [&](const Point& q) { pending.push_back(q); });
    }
}

/// Where the search for a key begins. Nodes of a kind of cube that are near each other begin near
/// each other: what is asked for together comes from memory together.
std::size_t SimplexGrid::home_of(std::uint64_t key) {
    constexpr std::uint64_t kLowest = 1 | std::uint64_t{1} << 21 | std::uint64_t{1} << 42;
    const auto all = static_cast<std::uint32_t>(key | key >> 21 | key >> 42);
    const int level = std::countr_zero(all | 1U << 20);
    // Two bits of each coordinate, side by side.
    const std::uint64_t inner = key & (3 * kLowest) << level, bits = inner >> level;
    return hash64(key - inner + static_cast<std::uint64_t>(level)) +
           ((bits | bits >> 19 | bits >> 38) & 63);
}

/// Where a key is or would be.
std::size_t SimplexGrid::slot_of(std::uint64_t key) const {
    const std::size_t mask = table_.size() - 1;
    std::size_t i = home_of(key) & mask;
    while (table_[i].node != kInvalidIndex && table_[i].key != key) i = (i + 1) & mask;
    return i;
}

/// False if it is a node already.
bool SimplexGrid::add(const Point& p) {
    const std::uint64_t key = key_of(p);
    Slot& slot = table_[slot_of(key)];
    if (slot.node != kInvalidIndex) return false;
    slot = {key, num_nodes()};
    points_.push_back(p);
    if (points_.size() * 2 > table_.size()) grow_table();
    return true;
}

void SimplexGrid::grow_table() {
    const std::vector<Slot> old = std::exchange(table_, std::vector<Slot>(2 * table_.size()));
    for (const Slot& slot : old)
        if (slot.node != kInvalidIndex) table_[slot_of(slot.key)] = slot;
}

/// The node that splits a tetrahedron, kInvalidIndex if it is a leaf.
Index SimplexGrid::midpoint(const Tet& tet) const {
    const Point &a = points_[tet.v[0]], &b = points_[tet.v[tet.tag]];
    Point middle;
    for (std::size_t k = 0; k < 3; ++k) {
        if ((a[k] + b[k]) & 1) return kInvalidIndex;
        middle[k] = (a[k] + b[k]) / 2;
    }
    return find(middle);
}

std::pair<SimplexGrid::Tet, SimplexGrid::Tet> SimplexGrid::halves(const Tet& tet, Index middle) {
    const std::size_t tag = tet.tag == 1 ? 3 : tet.tag - 1;
    Tet a{tet.v, tag}, b{tet.v, tag};
    a.v[tet.tag] = middle;
    for (std::size_t k = 0; k < tet.tag; ++k) b.v[k] = tet.v[k + 1];
    b.v[tet.tag] = middle;
    return {a, b};
}

/// The first tetrahedra from the root on, whole cubes or parts of them.
std::vector<SimplexGrid::Tet> SimplexGrid::subtrees() const {
    std::vector<Tet> level;
    for (int z = 0; z < num_cubes_[2]; ++z)
        for (int y = 0; y < num_cubes_[1]; ++y)
            for (int x = 0; x < num_cubes_[0]; ++x) {
                std::array<std::size_t, 3> axes{0, 1, 2};
                do {
                    Point p{x * kCubeUnits, y * kCubeUnits, z * kCubeUnits};
                    Tet tet{{find(p)}, 3};
                    for (std::size_t k = 0; k < 3; ++k) {
                        p[axes[k]] += kCubeUnits;
                        tet.v[k + 1] = find(p);
                    }
                    level.push_back(tet);
                } while (std::ranges::next_permutation(axes).found);
            }
    for (bool is_split = true; is_split && level.size() < kSubtrees;) {
        is_split = false;
        std::vector<Tet> next;
        for (const Tet& tet : level) {
            const Index middle = midpoint(tet);
            if (middle == kInvalidIndex) {
                next.push_back(tet);
                continue;
            }
            is_split = true;
            const auto [a, b] = halves(tet, middle);
            next.push_back(a);
            next.push_back(b);
        }
        level = std::move(next);
    }
    return level;
}

std::int64_t SimplexGrid::orientation(const std::array<Index, 4>& t) const {
    std::array<std::array<std::int64_t, 3>, 3> e;
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t k = 0; k < 3; ++k)
            e[i][k] = std::int64_t{points_[t[i + 1]][k]} - points_[t[0]][k];
    return e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) -
           e[0][1] * (e[1][0] * e[2][2] - e[1][2] * e[2][0]) +
           e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
}

}  // namespace pointbake
