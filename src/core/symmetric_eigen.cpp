// The cyclic Jacobi method [Golub13, 8.5]: nothing but + - * / and sqrt.
#include "core/symmetric_eigen.h"

#include <cmath>
#include <limits>
#include <utility>

namespace pointbake {
namespace {

// Convergence is quadratic: 4 or 5 sweeps reach the last bit. The limit only guards against NaN.
constexpr int kMaxSweeps = 12;

using Matrix = std::array<std::array<double, 3>, 3>;

/// Rotates in the plane of axes p and q so that a[p][q] becomes 0; v gathers the rotations. r is
/// the third axis.
void rotate(Matrix& a, Matrix& v, std::size_t p, std::size_t q, std::size_t r) {
    const double theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
    const double t =
        (theta < 0.0 ? -1.0 : 1.0) / (std::fabs(theta) + std::sqrt(theta * theta + 1.0));
    const double c = 1.0 / std::sqrt(t * t + 1.0);
    const double s = t * c;
    a[p][p] -= t * a[p][q];
    a[q][q] += t * a[p][q];
    a[p][q] = a[q][p] = 0.0;
    const double rp = a[r][p], rq = a[r][q];
    a[r][p] = a[p][r] = c * rp - s * rq;
    a[r][q] = a[q][r] = s * rp + c * rq;
    for (auto& row : v) {
        const double vp = row[p], vq = row[q];
        row[p] = c * vp - s * vq;
        row[q] = s * vp + c * vq;
    }
}

}  // namespace

EigenSystem eigen_system(const SymmetricMatrix& m) {
    Matrix a{{{m.xx, m.xy, m.xz}, {m.xy, m.yy, m.yz}, {m.xz, m.yz, m.zz}}};
    Matrix v{{{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}};
    // Below this an off-diagonal entry moves no eigenvalue of the size of the trace.
    const double negligible = std::numeric_limits<double>::epsilon() * 0.01 * (m.xx + m.yy + m.zz);
    for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
        if (std::fabs(a[0][1]) + std::fabs(a[0][2]) + std::fabs(a[1][2]) <= negligible) break;
        if (a[0][1] != 0.0) rotate(a, v, 0, 1, 2);
        if (a[0][2] != 0.0) rotate(a, v, 0, 2, 1);
        if (a[1][2] != 0.0) rotate(a, v, 1, 2, 0);
    }
    std::array<std::size_t, 3> order{0, 1, 2};
    const auto sort_pair = [&](std::size_t i, std::size_t j) {
        if (a[order[j]][order[j]] < a[order[i]][order[i]]) std::swap(order[i], order[j]);
    };
    sort_pair(0, 1);
    sort_pair(1, 2);
    sort_pair(0, 1);
    EigenSystem result;
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t j = order[k];
        result.values[k] = a[j][j];
        result.vectors[k] = {v[0][j], v[1][j], v[2][j]};
    }
    return result;
}

}  // namespace pointbake
