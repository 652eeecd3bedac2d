// Bisection after [Maubach95] from Kuhn's six tetrahedra per cube. Three bisections make eight
// cubes out of one; the diagonals of the small ones all meet in the middle of the large one.
#include "reconstruct/simplex_grid.h"

#include <algorithm>
#include <bit>

#include "core/hash.h"

namespace pointbake {
namespace {

constexpr std::int32_t kCubeUnits = 1 << SimplexGrid::kDepth;
constexpr std::size_t kFirstTable = 1U << 12;
// Enough parts for the threads, few enough that each is worth a thread's while.
constexpr std::size_t kSubtrees = 2048;

std::uint64_t hash_of(const SimplexGrid::Point& p) {
    const auto bits = [](std::int32_t v) { return static_cast<std::uint64_t>(v); };
    return hash64(bits(p[0]) | bits(p[1]) << 21 | bits(p[2]) << 42);
}

SimplexGrid::Point moved(SimplexGrid::Point p, std::size_t axis, std::int32_t by) {
    p[axis] += by;
    return p;
}

}  // namespace

SimplexGrid::SimplexGrid(Vec3d corner, double cube_size, std::array<int, 3> num_cubes)
    : corner_(corner),
      unit_(cube_size / kCubeUnits),
      num_cubes_(num_cubes),
      table_(kFirstTable, kInvalidIndex) {
    for (int z = 0; z <= num_cubes[2]; ++z)
        for (int y = 0; y <= num_cubes[1]; ++y)
            for (int x = 0; x <= num_cubes[0]; ++x)
                is_vertex_[find_or_add({x * kCubeUnits, y * kCubeUnits, z * kCubeUnits})] = 1;
    num_corners_ = num_nodes();
    for (int z = 0; z < num_cubes[2]; ++z)
        for (int y = 0; y < num_cubes[1]; ++y)
            for (int x = 0; x < num_cubes[0]; ++x)
                find_or_add({x * kCubeUnits + kCubeUnits / 2, y * kCubeUnits + kCubeUnits / 2,
                             z * kCubeUnits + kCubeUnits / 2});
}

Vec3d SimplexGrid::place(Index node) const {
    const Point& p = points_[node];
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
    for (std::size_t k = 0; k < 3; ++k)
        if (p[k] & half) {
            ++num_odd;
            odd = k;
        } else {
            even = k;
        }
    if (num_odd == 3) return {kCube, half, 0};
    return num_odd == 2 ? Shape{kFace, half, even} : Shape{kEdge, half, odd};
}

/// The diagonal of a cube (face) runs from its corner with even coordinates, counted in its own
/// edge length, to that with odd ones.
SimplexGrid::Point SimplexGrid::edge_end(const Point& p, bool is_odd) const {
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

std::array<Index, 2> SimplexGrid::edge(Index node) const {
    return {find(edge_end(points_[node], false)), find(edge_end(points_[node], true))};
}

double SimplexGrid::edge_length(Index node) const {
    const Shape s = shape(points_[node]);
    constexpr std::array<double, 3> kLengths{1.7320508075688772, 1.4142135623730951, 1.0};
    return kLengths[s.kind] * 2.0 * s.half * unit_;
}

double SimplexGrid::reach(Index node) const {
    const Shape s = shape(points_[node]);
    // To the corners of the cube, of the face; from an edge to the middles of the cubes around it.
    constexpr std::array<double, 3> kRadii{0.8660254037844386, 0.7071067811865476,
                                           0.7071067811865476};
    return kRadii[s.kind] * 2.0 * s.half * unit_;
}

int SimplexGrid::level(Index node) const {
    if (is_corner(node)) return 0;
    const Shape s = shape(points_[node]);
    return 3 * (kDepth - 1 - std::countr_zero(static_cast<std::uint32_t>(s.half))) + s.kind + 1;
}

/// Nodes that must be vertices before all tetrahedra around this node's edge exist.
template <class Visit>
void SimplexGrid::for_each_parent(const Point& p, Visit&& visit) const {
    const Shape s = shape(p);
    const auto visit_inside = [&](const Point& q) {
        if (is_inside(q)) visit(q);
    };
    if (s.kind == kFace) {
        for (const int side : {-1, 1}) visit_inside(moved(p, s.axis, side * s.half));
    } else if (s.kind == kEdge) {
        for (const std::size_t turn : {1U, 2U})
            for (const int side : {-1, 1})
                visit_inside(moved(p, (s.axis + turn) % 3, side * s.half));
    } else if (2 * s.half < kCubeUnits) {
        const Point even = edge_end(p, false);
        for (std::size_t k = 0; k < 3; ++k) visit(moved(even, k, 2 * (p[k] - even[k])));
    }
}

/// The inverse of the above.
template <class Visit>
void SimplexGrid::for_each_child(const Point& p, Visit&& visit) const {
    const Shape s = shape(p);
    const auto visit_inside = [&](const Point& q) {
        if (is_inside(q)) visit(q);
    };
    if (s.kind == kCube) {
        for (std::size_t k = 0; k < 3; ++k)
            for (const int side : {-1, 1}) visit_inside(moved(p, k, side * s.half));
    } else if (s.kind == kFace) {
        for (const std::size_t turn : {1U, 2U})
            for (const int side : {-1, 1})
                visit_inside(moved(p, (s.axis + turn) % 3, side * s.half));
    } else if (s.half > 1) {
        const std::int32_t quarter = s.half / 2;
        for (int octant = 0; octant < 8; ++octant) {
            Point q = p;
            for (int k = 0; k < 3; ++k)
                q[static_cast<std::size_t>(k)] += (octant >> k) & 1 ? quarter : -quarter;
            visit_inside(q);
        }
    }
}

void SimplexGrid::split(Index node) {
    std::vector<Index> pending{node};
    while (!pending.empty()) {
        const Index n = pending.back();
        pending.pop_back();
        if (is_vertex_[n]) continue;
        is_vertex_[n] = 1;
        const Point p = points_[n];
        for_each_parent(p, [&](const Point& q) {
            const Index parent = find_or_add(q);
            if (!is_vertex_[parent]) pending.push_back(parent);
        });
        for_each_child(p, [&](const Point& q) { find_or_add(q); });
    }
}

Index SimplexGrid::find(const Point& p) const {
    const std::size_t mask = table_.size() - 1;
    for (std::size_t i = hash_of(p) & mask;; i = (i + 1) & mask)
        if (table_[i] == kInvalidIndex || points_[table_[i]] == p) return table_[i];
}

Index SimplexGrid::find_or_add(const Point& p) {
    const std::size_t mask = table_.size() - 1;
    std::size_t i = hash_of(p) & mask;
    while (table_[i] != kInvalidIndex) {
        if (points_[table_[i]] == p) return table_[i];
        i = (i + 1) & mask;
    }
    const Index node = num_nodes();
    table_[i] = node;
    points_.push_back(p);
    is_vertex_.push_back(0);
    if (points_.size() * 2 > table_.size()) grow_table();
    return node;
}

void SimplexGrid::grow_table() {
    table_.assign(2 * table_.size(), kInvalidIndex);
    const std::size_t mask = table_.size() - 1;
    for (Index node = 0; node < num_nodes(); ++node) {
        std::size_t i = hash_of(points_[node]) & mask;
        while (table_[i] != kInvalidIndex) i = (i + 1) & mask;
        table_[i] = node;
    }
}

/// The vertex that splits a tetrahedron, kInvalidIndex if it is a leaf.
Index SimplexGrid::midpoint(const Tet& tet) const {
    const Point &a = points_[tet.v[0]], &b = points_[tet.v[tet.tag]];
    Point middle;
    for (std::size_t k = 0; k < 3; ++k) {
        if ((a[k] + b[k]) & 1) return kInvalidIndex;
        middle[k] = (a[k] + b[k]) / 2;
    }
    const Index node = find(middle);
    return node != kInvalidIndex && is_vertex_[node] ? node : kInvalidIndex;
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
