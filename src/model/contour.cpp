// Dual contouring [Ju02] with one vertex per sheet of surface in a cell, as in dual marching cubes
// [Nielson04], so that sheets that pass through the same cell stay apart. Vertices come from the
// quadric of the edge crossings' tangent planes; they are then pulled onto the surface.
#include "model/contour.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"

namespace pointbake {
namespace {

// Relative to the largest eigenvalue of the quadric: below it, a direction is along the surface (or
// its crease) and the vertex keeps the crossings' centre. Normals 25 degrees apart are a crease.
constexpr double kFlatDirection = 0.05;
// Roots and vertices lie this close to the surface, in cells.
constexpr double kRootAccuracy = 1e-9;
constexpr int kRootSteps = 60;
// Vertices stay in a cube of twice this many cells around the cell's centre: creases that run
// aslant leave the cell a little; farther out, quads would fold.
constexpr double kCellReach = 1.0;
constexpr int kProjectionSteps = 4;

struct Crossing {
    std::array<int, 3> at;  // lattice point at the edge's lower end
    int axis = 0;
    bool outward = false;  // the outside lies at the upper end
    Vec3d position, normal;
};

// The sheets of surface in a cell: which vertex each of the 12 edges belongs to.
using EdgeVertices = std::array<Index, 12>;

// A cell's corner k lies at bit 0 of k in x, bit 1 in y, bit 2 in z. Its edge 4 a + b + 2 c runs
// along axis a at place b of axis a+1 and place c of axis a+2.
constexpr int edge_of(int corner, int axis) {
    return 4 * axis + ((corner >> ((axis + 1) % 3)) & 1) + 2 * ((corner >> ((axis + 2) % 3)) & 1);
}

struct Lattice {
    std::array<int, 3> size{};  // lattice points
    const ContourGrid& grid;

    explicit Lattice(const ContourGrid& g) : grid(g) {
        for (std::size_t k = 0; k < 3; ++k) size[k] = g.num_blocks[k] * ContourGrid::kBlock + 1;
    }
    std::size_t count() const { return at(0, 0, size[2]); }
    std::size_t at(int i, int j, int k) const {
        return (static_cast<std::size_t>(k) * static_cast<std::size_t>(size[1]) +
                static_cast<std::size_t>(j)) *
                   static_cast<std::size_t>(size[0]) +
               static_cast<std::size_t>(i);
    }
    std::size_t at(std::array<int, 3> p) const { return at(p[0], p[1], p[2]); }
    Vec3d place(double i, double j, double k) const {
        return grid.low + Vec3d{i, j, k} * grid.spacing;
    }
};

// Samples one block, [8 b, 8 b + 8) in each axis (and the lattice's last layers).
void sample_block(const Solid& solid, const Lattice& lattice, std::array<int, 3> block,
                  std::vector<double>& values) {
    constexpr int kBlock = ContourGrid::kBlock;
    std::array<int, 3> begin{}, end{};
    for (std::size_t a = 0; a < 3; ++a) {
        begin[a] = block[a] * kBlock;
        end[a] = block[a] + 1 == lattice.grid.num_blocks[a] ? lattice.size[a] : begin[a] + kBlock;
    }
    const auto middle = [&](std::size_t a) { return begin[a] + 0.5 * kBlock; };
    const double center = solid.value(lattice.place(middle(0), middle(1), middle(2)));
    // Nothing crosses zero within the block, up to its farthest lattice point.
    const double reach = std::sqrt(3.0) * 0.5 * kBlock * lattice.grid.spacing * solid.steepness;
    const bool is_far = std::abs(center) > reach;
    for (int k = begin[2]; k < end[2]; ++k)
        for (int j = begin[1]; j < end[1]; ++j)
            for (int i = begin[0]; i < end[0]; ++i)
                values[lattice.at(i, j, k)] = is_far ? center : solid.value(lattice.place(i, j, k));
}

std::vector<double> sample_lattice(const Solid& solid, const Lattice& lattice,
                                   const Context& context) {
    std::vector<double> values(lattice.count());
    const auto [nx, ny, nz] = lattice.grid.num_blocks;
    parallel_for(context, static_cast<std::size_t>(ny) * static_cast<std::size_t>(nz), 1,
                 [&, nx = nx, ny = ny](std::size_t row, std::size_t) {
                     const int y = static_cast<int>(row) % ny, z = static_cast<int>(row) / ny;
                     for (int x = 0; x < nx; ++x) sample_block(solid, lattice, {x, y, z}, values);
                 });
    return values;
}

// Edges of the lattice whose ends lie on different sides, in the order of their lower ends.
std::vector<Crossing> find_crossings(const Lattice& lattice, const std::vector<double>& values,
                                     const Context& context) {
    const auto layers = static_cast<std::size_t>(lattice.size[2]);
    std::vector<std::vector<Crossing>> parts(layers);
    parallel_for(context, layers, 1, [&](std::size_t layer, std::size_t) {
        std::array<int, 3> p{0, 0, static_cast<int>(layer)};
        for (p[1] = 0; p[1] < lattice.size[1]; ++p[1])
            for (p[0] = 0; p[0] < lattice.size[0]; ++p[0])
                for (int axis = 0; axis < 3; ++axis) {
                    std::array<int, 3> q = p;
                    const auto a = static_cast<std::size_t>(axis);
                    if (++q[a] == lattice.size[a]) continue;
                    const bool inside = values[lattice.at(p)] < 0.0;
                    if (inside == (values[lattice.at(q)] < 0.0)) continue;
                    parts[layer].push_back({p, axis, inside, {}, {}});
                }
    });
    std::vector<Crossing> crossings;
    for (const auto& part : parts) crossings.insert(crossings.end(), part.begin(), part.end());
    return crossings;
}

// Where the solid's value is zero between a (value fa) and b (value fb): regula falsi after the
// Illinois rule, which never leaves the interval.
Vec3d find_root(const Solid& solid, Vec3d a, double fa, Vec3d b, double fb, double accuracy) {
    double low = 0.0, high = 1.0;
    Vec3d root = a;
    for (int step = 0; step < kRootSteps; ++step) {
        const double t = (low * fb - high * fa) / (fb - fa);
        root = a + (b - a) * t;
        const double f = solid.value(root);
        if (std::abs(f) < accuracy) break;
        if ((f < 0.0) == (fb < 0.0)) {
            high = t, fb = f, fa *= 0.5;
        } else {
            low = t, fa = f, fb *= 0.5;
        }
    }
    return root;
}

void locate_crossings(const Solid& solid, const Lattice& lattice, const std::vector<double>& values,
                      std::vector<Crossing>& crossings, const Context& context) {
    constexpr std::size_t kGrain = 512;
    const double accuracy = kRootAccuracy * lattice.grid.spacing;
    parallel_for(context, crossings.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t c = begin; c < end; ++c) {
            Crossing& x = crossings[c];
            std::array<int, 3> upper = x.at;
            ++upper[static_cast<std::size_t>(x.axis)];
            x.position = find_root(
                solid, lattice.place(x.at[0], x.at[1], x.at[2]), values[lattice.at(x.at)],
                lattice.place(upper[0], upper[1], upper[2]), values[lattice.at(upper)], accuracy);
            x.normal = solid.normal(x.position);
        }
    });
}

// Labels the crossed edges of a cell by sheet. On each face, crossings are linked in pairs; where
// all four edges are crossed, each inside corner is cut off by itself. That depends on the face
// alone, so neighbours agree. Uncrossed edges get -1.
std::array<int, 12> label_sheets(unsigned inside) {
    std::array<int, 12> label;
    for (int axis = 0; axis < 3; ++axis)
        for (int corner = 0; corner < 8; ++corner) {
            const int other = corner ^ (1 << axis);
            const bool crossed = ((inside >> corner) & 1) != ((inside >> other) & 1);
            const int edge = edge_of(corner, axis);
            label[static_cast<std::size_t>(edge)] = crossed ? edge : -1;
        }
    const auto link = [&](int e, int f) {
        const int from = label[static_cast<std::size_t>(e)];
        const int to = label[static_cast<std::size_t>(f)];
        for (int& l : label)
            if (l == std::max(from, to)) l = std::min(from, to);
    };
    for (int axis = 0; axis < 3; ++axis)
        for (int side = 0; side < 2; ++side) {
            const int u = (axis + 1) % 3, v = (axis + 2) % 3;
            const int base = side << axis;
            const std::array<int, 4> ring{base, base | (1 << u), base | (1 << u) | (1 << v),
                                          base | (1 << v)};
            std::array<int, 4> edges{}, crossed{};
            std::size_t num_crossed = 0;
            for (std::size_t k = 0; k < 4; ++k) {
                edges[k] = edge_of(ring[k], k % 2 == 0 ? u : v);
                if (k >= 2) edges[k] = edge_of(ring[(k + 1) % 4], k % 2 == 0 ? u : v);
                if (label[static_cast<std::size_t>(edges[k])] >= 0)
                    crossed[num_crossed++] = edges[k];
            }
            if (num_crossed == 2) link(crossed[0], crossed[1]);
            if (num_crossed != 4) continue;
            for (std::size_t k = 0; k < 4; ++k)
                if ((inside >> ring[k]) & 1) link(edges[(k + 3) % 4], edges[k]);
        }
    return label;
}

// Eigenvectors (columns of v) of a symmetric matrix by cyclic Jacobi rotations: + - * / sqrt only.
void diagonalize(std::array<std::array<double, 3>, 3>& a, std::array<Vec3d, 3>& v) {
    v = {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}};
    constexpr int kSweeps = 8;  // converges quadratically: far more than doubles need
    for (int sweep = 0; sweep < kSweeps; ++sweep)
        for (std::size_t p = 0; p < 2; ++p)
            for (std::size_t q = p + 1; q < 3; ++q) {
                if (a[p][q] == 0.0) continue;
                const double theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
                const double t =
                    (theta < 0.0 ? -1.0 : 1.0) / (std::abs(theta) + std::sqrt(theta * theta + 1.0));
                const double c = 1.0 / std::sqrt(t * t + 1.0), s = t * c;
                for (std::size_t k = 0; k < 3; ++k) {
                    const double kp = a[k][p], kq = a[k][q];
                    a[k][p] = c * kp - s * kq;
                    a[k][q] = s * kp + c * kq;
                }
                for (std::size_t k = 0; k < 3; ++k) {
                    const double pk = a[p][k], qk = a[q][k];
                    a[p][k] = c * pk - s * qk;
                    a[q][k] = s * pk + c * qk;
                }
                const Vec3d vp = v[p], vq = v[q];
                v[p] = vp * c - vq * s;
                v[q] = vp * s + vq * c;
            }
}

// The point that is closest to all tangent planes, starting from the crossings' centre and moving
// only in directions that the planes tell something about [Ju02, 2.3].
Vec3d place_vertex(const Solid& solid, const std::vector<const Crossing*>& sheet, Vec3d low,
                   double spacing) {
    Vec3d center, outward;
    for (const Crossing* x : sheet) {
        center += x->position;
        outward += x->normal;
    }
    center = center / static_cast<double>(sheet.size());
    outward = normalized(outward);
    std::array<std::array<double, 3>, 3> a{};
    Vec3d rhs;
    for (const Crossing* x : sheet) {
        const Vec3d n = x->normal;
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t j = 0; j < 3; ++j) a[i][j] += n[i] * n[j];
        rhs += n * dot(n, x->position - center);
    }
    std::array<Vec3d, 3> axes;
    diagonalize(a, axes);
    const double largest = std::max({a[0][0], a[1][1], a[2][2]});
    Vec3d vertex = center;
    for (std::size_t k = 0; k < 3; ++k)
        if (a[k][k] > kFlatDirection * largest) vertex += axes[k] * (dot(axes[k], rhs) / a[k][k]);
    const Vec3d local = vertex - low - Vec3d{0.5, 0.5, 0.5} * spacing;
    const double off = std::max({std::abs(local.x), std::abs(local.y), std::abs(local.z)});
    if (off > kCellReach * spacing) vertex = center;
    for (int step = 0; step < kProjectionSteps; ++step) {
        const double f = solid.value(vertex);
        if (std::abs(f) < kRootAccuracy * spacing) break;
        vertex += outward * -f;
    }
    return vertex;
}

struct Sheets {
    std::vector<EdgeVertices> cells;  // cells with surface
    std::vector<Index> cell_of;       // per lattice point: its cell's place in `cells`
    std::vector<Vec3d> positions;
};

// Edge crossings by (axis, lattice point).
struct CrossingTable {
    std::array<std::vector<Index>, 3> index;

    CrossingTable(const Lattice& lattice, const std::vector<Crossing>& crossings) {
        for (auto& list : index) list.assign(lattice.count(), kInvalidIndex);
        for (Index c = 0; c < crossings.size(); ++c)
            index[static_cast<std::size_t>(crossings[c].axis)][lattice.at(crossings[c].at)] = c;
    }
};

// Finds the sheets of one layer of cells after the other.
class SheetFinder {
 public:
    struct Layer {
        std::vector<std::size_t> places;  // lattice points of the cells with surface
        std::vector<EdgeVertices> cells;
        std::vector<Vec3d> positions;
    };

    SheetFinder(const Solid& solid, const Lattice& lattice, const std::vector<double>& values,
                const std::vector<Crossing>& crossings)
        : solid_(solid),
          lattice_(lattice),
          values_(values),
          crossings_(crossings),
          table_(lattice, crossings) {
        for (unsigned inside = 0; inside < 256; ++inside) labels_.push_back(label_sheets(inside));
    }
    Layer find(int k) const {
        Layer layer;
        for (int j = 0; j + 1 < lattice_.size[1]; ++j)
            for (int i = 0; i + 1 < lattice_.size[0]; ++i) {
                const unsigned inside = inside_corners({i, j, k});
                if (inside == 0 || inside == 255) continue;
                layer.places.push_back(lattice_.at(i, j, k));
                add_cell({i, j, k}, labels_[inside], layer);
            }
        return layer;
    }

 private:
    // One bit per corner.
    unsigned inside_corners(std::array<int, 3> cell) const {
        unsigned inside = 0;
        for (int c = 0; c < 8; ++c)
            if (values_[lattice_.at(cell[0] + (c & 1), cell[1] + (c >> 1 & 1),
                                    cell[2] + (c >> 2))] < 0.0)
                inside |= 1U << c;
        return inside;
    }
    void add_cell(std::array<int, 3> cell, const std::array<int, 12>& label, Layer& layer) const {
        EdgeVertices vertices;
        vertices.fill(kInvalidIndex);
        std::vector<const Crossing*> members;
        members.reserve(12);
        for (int sheet = 0; sheet < 12; ++sheet) {
            members.clear();
            for (int edge = 0; edge < 12; ++edge) {
                if (label[static_cast<std::size_t>(edge)] != sheet) continue;
                const auto axis = static_cast<std::size_t>(edge / 4);
                std::array<int, 3> at = cell;
                at[(axis + 1) % 3] += edge & 1;
                at[(axis + 2) % 3] += (edge >> 1) & 1;
                members.push_back(&crossings_[table_.index[axis][lattice_.at(at)]]);
                vertices[static_cast<std::size_t>(edge)] =
                    static_cast<Index>(layer.positions.size());
            }
            if (members.empty()) continue;
            layer.positions.push_back(place_vertex(
                solid_, members, lattice_.place(cell[0], cell[1], cell[2]), lattice_.grid.spacing));
        }
        layer.cells.push_back(vertices);
    }

    const Solid& solid_;
    const Lattice& lattice_;
    const std::vector<double>& values_;
    const std::vector<Crossing>& crossings_;
    CrossingTable table_;
    std::vector<std::array<int, 12>> labels_;  // by inside corners
};

// Layers one after the other, vertices numbered through.
Sheets join_layers(const Lattice& lattice, const std::vector<SheetFinder::Layer>& layers) {
    Sheets sheets;
    sheets.cell_of.assign(lattice.count(), kInvalidIndex);
    for (const SheetFinder::Layer& layer : layers) {
        const auto offset = static_cast<Index>(sheets.positions.size());
        for (std::size_t c = 0; c < layer.cells.size(); ++c) {
            sheets.cell_of[layer.places[c]] = static_cast<Index>(sheets.cells.size());
            sheets.cells.push_back(layer.cells[c]);
            for (Index& v : sheets.cells.back())
                if (v != kInvalidIndex) v += offset;
        }
        sheets.positions.insert(sheets.positions.end(), layer.positions.begin(),
                                layer.positions.end());
    }
    return sheets;
}

// The quad across an edge, counter-clockwise seen from outside.
std::array<Index, 4> quad_of(const Crossing& x, const Lattice& lattice, const Sheets& sheets) {
    constexpr int kAround[4][2] = {{1, 1}, {0, 1}, {0, 0}, {1, 0}};
    std::array<Index, 4> quad{};
    for (std::size_t k = 0; k < 4; ++k) {
        const auto axis = static_cast<std::size_t>(x.axis);
        std::array<int, 3> cell = x.at;
        cell[(axis + 1) % 3] -= kAround[k][0];
        cell[(axis + 2) % 3] -= kAround[k][1];
        const EdgeVertices& edges = sheets.cells[sheets.cell_of[lattice.at(cell)]];
        const int edge = 4 * x.axis + kAround[k][0] + 2 * kAround[k][1];
        quad[x.outward ? k : 3 - k] = edges[static_cast<std::size_t>(edge)];
    }
    return quad;
}

// Cuts a quad along the diagonal whose triangles keep closest to the surface's normal.
void add_quad(const std::array<Index, 4>& q, Vec3d normal, Mesh& mesh) {
    const auto agreement = [&](Index a, Index b, Index c) {
        const Vec3d pa = mesh.positions[a];
        return dot(normalized(cross(mesh.positions[b] - pa, mesh.positions[c] - pa)), normal);
    };
    const double first = std::min(agreement(q[0], q[1], q[2]), agreement(q[0], q[2], q[3]));
    const double second = std::min(agreement(q[1], q[2], q[3]), agreement(q[1], q[3], q[0]));
    if (first >= second) {
        mesh.triangles.push_back({q[0], q[1], q[2]});
        mesh.triangles.push_back({q[0], q[2], q[3]});
    } else {
        mesh.triangles.push_back({q[1], q[2], q[3]});
        mesh.triangles.push_back({q[1], q[3], q[0]});
    }
}

}  // namespace

Mesh contour(const Solid& solid, const ContourGrid& grid, const Context& context) {
    const Lattice lattice(grid);
    const std::vector<double> values = sample_lattice(solid, lattice, context);
    std::vector<Crossing> crossings = find_crossings(lattice, values, context);
    locate_crossings(solid, lattice, values, crossings, context);
    const SheetFinder finder(solid, lattice, values, crossings);
    std::vector<SheetFinder::Layer> layers(static_cast<std::size_t>(lattice.size[2] - 1));
    parallel_for(context, layers.size(), 1,
                 [&](std::size_t k, std::size_t) { layers[k] = finder.find(static_cast<int>(k)); });
    Sheets sheets = join_layers(lattice, layers);

    Mesh mesh;
    mesh.positions = std::move(sheets.positions);
    mesh.triangles.reserve(2 * crossings.size());
    for (const Crossing& x : crossings) add_quad(quad_of(x, lattice, sheets), x.normal, mesh);
    return mesh;
}

}  // namespace pointbake
