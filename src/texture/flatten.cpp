#include "texture/flatten.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>

namespace pointbake {
namespace {

constexpr int kMaxSteps = 24;
constexpr int kPatience = 6;      // steps without progress
constexpr double kWanted = 1.15;  // triangles stretched by more gain weight
constexpr double kLargestWeight = 1e4;

// 2 x 2, by rows.
struct Matrix {
    double a = 1.0, b = 0.0, c = 0.0, d = 1.0;
};

class Flattener {
 public:
    Flattener(const Mesh& mesh, std::span<const Index> triangles, FlatCorners corners) {
        number_vertices(mesh, triangles);
        for (std::size_t i = 0; i < triangles.size(); ++i) {
            for (std::size_t k = 0; k < 3; ++k) places_[vertices_[i][k]] = corners[i][k];
            rest_.push_back(rest_shape(mesh, triangles[i]));
        }
        weights_.assign(triangles.size(), 1.0);
    }

    std::optional<FlatCorners> run() {
        double best = HUGE_VAL;
        int since_best = 0;
        for (int step = 0; step <= kMaxSteps; ++step) {
            scale_to_area();
            const double stretch = look();
            if (!(stretch < HUGE_VAL)) return std::nullopt;
            if (stretch <= kMaxChartStretch) return corners();
            since_best = stretch < 0.99 * best ? 0 : since_best + 1;
            best = std::min(best, stretch);
            if (since_best > kPatience || !solve()) return std::nullopt;
        }
        return std::nullopt;
    }

 private:
    // A triangle in its own plane: corner 0 at the origin, corner 1 on the x axis.
    struct Rest {
        Vec2d b, c;
        double area = 0.0;
    };

    void number_vertices(const Mesh& mesh, std::span<const Index> triangles) {
        std::vector<Index> used;
        for (const Index t : triangles)
            used.insert(used.end(), mesh.triangles[t].begin(), mesh.triangles[t].end());
        std::sort(used.begin(), used.end());
        used.erase(std::unique(used.begin(), used.end()), used.end());
        for (const Index t : triangles) {
            Triangle local;
            for (std::size_t k = 0; k < 3; ++k)
                local[k] = static_cast<Index>(
                    std::lower_bound(used.begin(), used.end(), mesh.triangles[t][k]) -
                    used.begin());
            vertices_.push_back(local);
        }
        places_.resize(used.size());
    }

    static Rest rest_shape(const Mesh& mesh, Index t) {
        const Triangle& tri = mesh.triangles[t];
        const Vec3d b = mesh.positions[tri[1]] - mesh.positions[tri[0]],
                    c = mesh.positions[tri[2]] - mesh.positions[tri[0]];
        const double l = length(b), area = 0.5 * length(cross(b, c));
        if (!(area > 0.0)) return {};
        return {{l, 0.0}, {dot(b, c) / l, 2.0 * area / l}, area};
    }

    void scale_to_area() {
        double wanted = 0.0, have = 0.0;
        for (std::size_t i = 0; i < rest_.size(); ++i) {
            const auto [b, c] = sides(i);
            wanted += rest_[i].area;
            have += 0.5 * cross(b, c);
        }
        if (!(have > 0.0)) return;
        const double scale = std::sqrt(wanted / have);
        for (Vec2d& p : places_) p = p * scale;
    }

    std::pair<Vec2d, Vec2d> sides(std::size_t i) const {
        const Triangle& v = vertices_[i];
        return {places_[v[1]] - places_[v[0]], places_[v[2]] - places_[v[0]]};
    }

    // The map from the rest shape to the plane.
    Matrix map_of(std::size_t i) const {
        const Rest& rest = rest_[i];
        const auto [b, c] = sides(i);
        const double det = rest.b.x * rest.c.y;
        // Columns: images of the axes.
        const Vec2d x = b / rest.b.x, y = (c * rest.b.x - b * rest.c.x) / det;
        return {x.x, y.x, x.y, y.y};
    }

    // Finds every triangle's rotation and weight; the largest stretch, infinite if one is turned
    // over.
    double look() {
        double worst = 1.0;
        rotations_.resize(rest_.size());
        for (std::size_t i = 0; i < rest_.size(); ++i) {
            if (!(rest_[i].area > 0.0)) continue;
            const Matrix m = map_of(i);
            if (!(m.a * m.d - m.b * m.c > 0.0)) return HUGE_VAL;
            // Closed form of the singular values: half their sum and half their difference.
            const double e = 0.5 * (m.a + m.d), f = 0.5 * (m.c - m.b);
            const double g = 0.5 * (m.a - m.d), h = 0.5 * (m.b + m.c);
            const double sum = std::sqrt(e * e + f * f), difference = std::sqrt(g * g + h * h);
            rotations_[i] = {e / sum, -f / sum, f / sum, e / sum};
            const double stretch = std::max(sum + difference, 1.0 / (sum - difference));
            worst = std::max(worst, stretch);
            if (stretch > kWanted) {
                const double more = std::min(stretch / kWanted, 2.0);
                weights_[i] = std::min(kLargestWeight, weights_[i] * more * more);
            }
        }
        return worst;
    }

    // The vertices for which the maps come nearest to the rotations.
    bool solve() {
        const auto n = static_cast<Eigen::Index>(places_.size());
        std::vector<Eigen::Triplet<double>> entries;
        Eigen::MatrixX2d right = Eigen::MatrixX2d::Zero(n, 2);
        for (std::size_t i = 0; i < rest_.size(); ++i) {
            const Rest& rest = rest_[i];
            if (!(rest.area > 0.0)) continue;
            const std::array<Vec2d, 3> x{Vec2d{}, rest.b, rest.c};
            const Matrix& r = rotations_[i];
            for (std::size_t k = 0; k < 3; ++k) {
                // Edge from corner k to l, seen from corner m.
                const std::size_t l = (k + 1) % 3, m = (k + 2) % 3;
                const Vec2d p = x[k] - x[m], q = x[l] - x[m], d = x[k] - x[l];
                const double w = 0.5 * weights_[i] * dot(p, q) / (2.0 * rest.area);
                const auto a = static_cast<Eigen::Index>(vertices_[i][k]),
                           b = static_cast<Eigen::Index>(vertices_[i][l]);
                entries.emplace_back(a, a, w);
                entries.emplace_back(b, b, w);
                entries.emplace_back(a, b, -w);
                entries.emplace_back(b, a, -w);
                const double tx = w * (r.a * d.x + r.b * d.y), ty = w * (r.c * d.x + r.d * d.y);
                right(a, 0) += tx, right(a, 1) += ty;
                right(b, 0) -= tx, right(b, 1) -= ty;
            }
        }
        // Vertices of triangles without an area alone stay; one more must.
        std::vector<double> diagonal(places_.size(), 0.0);
        double largest = 0.0;
        for (const auto& e : entries)
            if (e.row() == e.col()) diagonal[static_cast<std::size_t>(e.row())] += e.value();
        for (const double d : diagonal) largest = std::max(largest, d);
        for (std::size_t v = 0; v < diagonal.size(); ++v) {
            if (v != 0 && diagonal[v] > 1e-12 * largest) continue;
            const auto a = static_cast<Eigen::Index>(v);
            const double hold = largest > 0.0 ? largest : 1.0;
            entries.emplace_back(a, a, hold);
            right(a, 0) += hold * places_[v].x;
            right(a, 1) += hold * places_[v].y;
        }
        Eigen::SparseMatrix<double> matrix(n, n);
        matrix.setFromTriplets(entries.begin(), entries.end());
        if (!analysed_) solver_.analyzePattern(matrix), analysed_ = true;
        solver_.factorize(matrix);
        if (solver_.info() != Eigen::Success) return false;
        const Eigen::MatrixX2d solved = solver_.solve(right);
        for (std::size_t v = 0; v < places_.size(); ++v) {
            const auto a = static_cast<Eigen::Index>(v);
            places_[v] = {solved(a, 0), solved(a, 1)};
        }
        return true;
    }

    FlatCorners corners() const {
        FlatCorners out(vertices_.size());
        for (std::size_t i = 0; i < out.size(); ++i)
            for (std::size_t k = 0; k < 3; ++k) out[i][k] = places_[vertices_[i][k]];
        return out;
    }

    std::vector<Triangle> vertices_;  // per triangle, numbered within the chart
    std::vector<Rest> rest_;
    std::vector<Vec2d> places_;  // per vertex
    std::vector<double> weights_;
    std::vector<Matrix> rotations_;
    Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver_;
    bool analysed_ = false;
};

}  // namespace

std::optional<FlatCorners> flatten(const Mesh& mesh, std::span<const Index> triangles,
                                   FlatCorners corners) {
    return Flattener(mesh, triangles, std::move(corners)).run();
}

}  // namespace pointbake
