#include "core/local_quadric.h"

#include <cmath>

#include "core/symmetric_eigen.h"

namespace pointbake {
namespace {

constexpr double kLineRatio = 0.02;      // second eigenvalue over the largest: a line below it
constexpr double kSmallestPivot = 1e-7;  // of the normal equations, of their diagonal

}  // namespace

std::optional<TangentFrame> tangent_frame(std::span<const Vec3d> positions, Vec3d p,
                                          std::span<const Neighbor> neighbors) {
    Vec3d mean;
    SymmetricMatrix c;
    for (const Neighbor& n : neighbors) {
        const Vec3d q = positions[n.index] - p;
        mean += q;
        c.add(q, 1.0);
    }
    c.add(mean, -1.0 / static_cast<double>(neighbors.size()));
    const EigenSystem e = eigen_system(c);
    if (!(e.values[1] > kLineRatio * e.values[2])) return std::nullopt;
    return TangentFrame{p, e.vectors[2], e.vectors[1], e.vectors[0]};
}

void QuadricFit::add(Vec3d q, double weight) {
    const Vec3d d = (q - frame_.origin) * (1.0 / scale_);
    const double x = dot(d, frame_.u), y = dot(d, frame_.v), z = dot(d, frame_.normal);
    const std::array<double, 6> row{1.0, x, y, x * x, x * y, y * y};
    for (std::size_t i = 0; i < 6; ++i) {
        const double w = weight * row[i];
        for (std::size_t j = 0; j <= i; ++j) normal_[i][j] += w * row[j];
        right_[i] += w * z;
    }
    squares_ += weight * z * z;
    weights_ += weight;
}

std::optional<Quadric> QuadricFit::solve() const {
    if (!(weights_ > 6.0)) return std::nullopt;
    // Cholesky; the first unknown's variance is the squared length of L^-1 e0.
    auto l = normal_;
    for (std::size_t i = 0; i < 6; ++i) {
        for (std::size_t j = 0; j <= i; ++j) {
            double sum = l[i][j];
            for (std::size_t k = 0; k < j; ++k) sum -= l[i][k] * l[j][k];
            if (i == j) {
                if (!(sum > kSmallestPivot * normal_[i][i])) return std::nullopt;
                l[i][i] = std::sqrt(sum);
            } else {
                l[i][j] = sum / l[j][j];
            }
        }
    }
    std::array<double, 6> b = right_, e{1.0, 0.0, 0.0, 0.0, 0.0, 0.0};
    double fitted = 0.0;
    Quadric q;
    for (std::size_t i = 0; i < 6; ++i) {
        for (std::size_t k = 0; k < i; ++k) {
            b[i] -= l[i][k] * b[k];
            e[i] -= l[i][k] * e[k];
        }
        b[i] /= l[i][i];
        e[i] /= l[i][i];
        fitted += b[i] * b[i];
        q.leverage += e[i] * e[i];
    }
    for (std::size_t i = 6; i-- > 0;) {
        for (std::size_t k = i + 1; k < 6; ++k) b[i] -= l[k][i] * b[k];
        b[i] /= l[i][i];
    }
    const double rest = squares_ - fitted > 0.0 ? squares_ - fitted : 0.0;
    q.variance = rest / (weights_ - 6.0) * scale_ * scale_;
    q.c = {b[0] * scale_, b[1], b[2], b[3] / scale_, b[4] / scale_, b[5] / scale_};
    return q;
}

}  // namespace pointbake
