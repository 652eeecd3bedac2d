// Linear finite elements, solved by conjugate gradients. The preconditioner is the hierarchical
// basis [Yserentant86]: the grid's own bisections are the levels. Solved again with each
// tetrahedron weighted by one over the gradient there, the energy becomes the integral of the
// gradient, which is the area of the level sets: the zero set tends to the membrane of least area
// [Strang83].
#include "reconstruct/membrane.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "core/parallel.h"

namespace pointbake {
namespace {

constexpr std::size_t kGrain = 1U << 13;
// The error halves in about four steps; a half of it moves the surface by less than a cell.
constexpr int kMaxSteps = 60;
// Solutions, each but the first with the weights of the one before.
constexpr int kRounds = 5;
// Slopes below this, per cube of the grid, count as flat.
constexpr double kLeastSlope = 0.2;
constexpr double kTolerance = 1e-6;  // of the first residual, squared

/// Integrals of grad(a) . grad(b) over a tetrahedron, for its vertices' hat functions a and b.
std::array<std::array<double, 4>, 4> stiffness(const std::array<Vec3d, 4>& p) {
    std::array<Vec3d, 4> gradient;
    const double volume6 = dot(p[1] - p[0], cross(p[2] - p[0], p[3] - p[0]));
    gradient[1] = cross(p[2] - p[0], p[3] - p[0]) / volume6;
    gradient[2] = cross(p[3] - p[0], p[1] - p[0]) / volume6;
    gradient[3] = cross(p[1] - p[0], p[2] - p[0]) / volume6;
    gradient[0] = -(gradient[1] + gradient[2] + gradient[3]);
    const double volume = std::abs(volume6) / 6.0;
    std::array<std::array<double, 4>, 4> k;
    for (std::size_t a = 0; a < 4; ++a)
        for (std::size_t b = 0; b < 4; ++b) k[a][b] = volume * dot(gradient[a], gradient[b]);
    return k;
}

class Solver {
 public:
    Solver(const SimplexGrid& grid, std::span<const std::uint8_t> is_given, const Context& context)
        : grid_(grid), context_(context), row_(grid.num_nodes(), kInvalidIndex) {
        number_rows(is_given);
        tets_ = grid_.leaves(context_, [&](const std::array<Index, 4>& t) {
            return std::ranges::any_of(t, [&](Index v) { return row_[v] != kInvalidIndex; });
        });
        find_parents();
    }

    void solve(std::vector<float>& values) {
        start(values);
        for (int round = 0; round < kRounds && (round == 0 || is_crossed(values)); ++round) {
            assemble(values, round > 0);
            solve_linear(values);
        }
    }

 private:
    /// Whether the zero set passes where values are not given: else there is no membrane.
    bool is_crossed(std::span<const float> values) const {
        return std::ranges::any_of(tets_, [&](const std::array<Index, 4>& t) {
            const bool is_inside = values[t[0]] < 0.0F;
            return std::ranges::any_of(t, [&](Index v) { return (values[v] < 0.0F) != is_inside; });
        });
    }

    void solve_linear(std::vector<float>& values) {
        std::vector<double> residual = right_, direction, image(size());
        apply(x_, image);
        for (std::size_t i = 0; i < size(); ++i) residual[i] -= image[i];
        std::vector<double> z = precondition(residual);
        direction = z;
        double rz = product(residual, z);
        const double goal = kTolerance * rz;
        for (int step = 0; step < kMaxSteps && rz > goal; ++step) {
            apply(direction, image);
            const double alpha = rz / product(direction, image);
            add(x_, alpha, direction);
            add(residual, -alpha, image);
            z = precondition(residual);
            const double next = product(residual, z), beta = next / rz;
            rz = next;
            for (std::size_t i = 0; i < size(); ++i) direction[i] = z[i] + beta * direction[i];
        }
        for (std::size_t i = 0; i < size(); ++i) values[nodes_[i]] = static_cast<float>(x_[i]);
    }

    struct Entry {
        Index column;
        double value;
    };
    std::size_t size() const { return nodes_.size(); }

    /// Unknowns from coarse to fine.
    void number_rows(std::span<const std::uint8_t> is_given) {
        for (Index node = 0; node < grid_.num_nodes(); ++node)
            if (!is_given[node]) nodes_.push_back(node);
        std::ranges::stable_sort(nodes_, {}, [&](Index node) { return grid_.level(node); });
        for (Index i = 0; i < nodes_.size(); ++i) row_[nodes_[i]] = i;
    }

    void assemble(std::span<const float> values, bool is_reweighted) {
        begin_.assign(size() + 1, 0);
        for (const auto& t : tets_)
            for (const Index v : t)
                if (row_[v] != kInvalidIndex) begin_[row_[v] + 1] += 3;
        std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
        entries_.resize(begin_.back());
        diagonal_.assign(size(), 0.0);
        right_.assign(size(), 0.0);
        std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
        for (const auto& t : tets_) {
            auto k = stiffness(
                {grid_.place(t[0]), grid_.place(t[1]), grid_.place(t[2]), grid_.place(t[3])});
            if (is_reweighted) reweight(k, values, t);
            for (std::size_t a = 0; a < 4; ++a) {
                const Index row = row_[t[a]];
                if (row == kInvalidIndex) continue;
                diagonal_[row] += k[a][a];
                for (std::size_t b = 0; b < 4; ++b) {
                    if (b == a) continue;
                    const Index column = row_[t[b]];
                    if (column == kInvalidIndex) right_[row] -= k[a][b] * double{values[t[b]]};
                    entries_[next[row]++] =
                        column == kInvalidIndex ? Entry{row, 0.0} : Entry{column, k[a][b]};
                }
            }
        }
        merge_entries();
    }

    /// Each column once a row.
    void merge_entries() {
        std::vector<std::size_t> count(size());
        parallel_for(context_, size(), kGrain, [&](std::size_t first, std::size_t last) {
            for (std::size_t i = first; i < last; ++i) {
                const std::span row(entries_.data() + begin_[i], begin_[i + 1] - begin_[i]);
                std::ranges::stable_sort(row, {}, &Entry::column);
                for (const Entry& e : row) {
                    if (e.value == 0.0) continue;
                    if (count[i] > 0 && row[count[i] - 1].column == e.column)
                        row[count[i] - 1].value += e.value;
                    else
                        row[count[i]++] = e;
                }
            }
        });
        std::size_t end = 0;
        for (std::size_t i = 0; i < size(); ++i) {
            const std::size_t from = begin_[i];
            begin_[i] = end;
            for (std::size_t k = 0; k < count[i]; ++k) entries_[end++] = entries_[from + k];
        }
        begin_[size()] = end;
        entries_.resize(end);
    }

    /// By one over the gradient, which is volume(t)^(1/2) x energy^(1/2) of the values.
    void reweight(std::array<std::array<double, 4>, 4>& k, std::span<const float> values,
                  const std::array<Index, 4>& t) const {
        double energy = 0.0;
        for (std::size_t a = 0; a < 4; ++a)
            for (std::size_t b = 0; b < 4; ++b)
                energy += k[a][b] * double{values[t[a]]} * double{values[t[b]]};
        const Vec3d p = grid_.place(t[0]);
        const double volume = std::abs(dot(grid_.place(t[1]) - p,
                                           cross(grid_.place(t[2]) - p, grid_.place(t[3]) - p))) /
                              6.0;
        const double slope2 = std::max(energy, 0.0) / volume,
                     least = kLeastSlope / grid_.cube_size();
        const double weight = 1.0 / std::sqrt(slope2 + least * least);
        for (auto& row : k)
            for (double& entry : row) entry *= weight;
    }

    void find_parents() {
        parents_.assign(size(), {kInvalidIndex, kInvalidIndex});
        for (std::size_t i = 0; i < size(); ++i) {
            if (grid_.is_corner(nodes_[i])) continue;
            const auto [a, b] = grid_.edge(grid_.point(nodes_[i]));
            parents_[i] = {row_[a], row_[b]};
        }
    }

    /// The mean of the edge's ends, from coarse to fine.
    void start(std::vector<float>& values) {
        x_.resize(size());
        for (std::size_t i = 0; i < size(); ++i) {
            float& value = values[nodes_[i]];
            value = 0.0F;
            if (!grid_.is_corner(nodes_[i])) {
                const auto [a, b] = grid_.edge(grid_.point(nodes_[i]));
                value = 0.5F * (values[a] + values[b]);
            }
            x_[i] = value;
        }
    }

    void apply(const std::vector<double>& x, std::vector<double>& out) const {
        parallel_for(context_, size(), kGrain, [&](std::size_t first, std::size_t last) {
            for (std::size_t i = first; i < last; ++i) {
                double sum = diagonal_[i] * x[i];
                for (std::size_t k = begin_[i]; k < begin_[i + 1]; ++k)
                    sum += entries_[k].value * x[entries_[k].column];
                out[i] = sum;
            }
        });
    }

    /// To hierarchical coefficients, scaled there, and back.
    std::vector<double> precondition(std::vector<double> r) const {
        for (std::size_t i = size(); i-- > 0;)
            for (const Index parent : parents_[i])
                if (parent != kInvalidIndex) r[parent] += 0.5 * r[i];
        for (std::size_t i = 0; i < size(); ++i) {
            r[i] /= diagonal_[i];
            for (const Index parent : parents_[i])
                if (parent != kInvalidIndex) r[i] += 0.5 * r[parent];
        }
        return r;
    }

    double product(const std::vector<double>& a, const std::vector<double>& b) const {
        return parallel_reduce(
            context_, size(), kGrain, 0.0,
            [&](std::size_t first, std::size_t last) {
                double sum = 0.0;
                for (std::size_t i = first; i < last; ++i) sum += a[i] * b[i];
                return sum;
            },
            [](double a_sum, double b_sum) { return a_sum + b_sum; });
    }

    static void add(std::vector<double>& a, double factor, const std::vector<double>& b) {
        for (std::size_t i = 0; i < a.size(); ++i) a[i] += factor * b[i];
    }

    const SimplexGrid& grid_;
    const Context& context_;
    std::vector<std::array<Index, 4>> tets_;  ///< with an unknown vertex
    std::vector<Index> nodes_;                ///< of each row
    std::vector<Index> row_;                  ///< of each node
    std::vector<std::size_t> begin_;
    std::vector<Entry> entries_;
    std::vector<double> diagonal_, right_, x_;
    std::vector<std::array<Index, 2>> parents_;  ///< rows of the edge's ends
};

}  // namespace

void span_membrane_in_place(const SimplexGrid& grid, std::span<const std::uint8_t> is_given,
                            std::vector<float>& values, const Context& context) {
    Solver(grid, is_given, context).solve(values);
}

}  // namespace pointbake
