// Eigenvalues and eigenvectors of a symmetric 3x3 matrix.
#pragma once

#include <array>

#include "pointbake/vec.h"

namespace pointbake {

struct SymmetricMatrix {
    double xx = 0.0, yy = 0.0, zz = 0.0, xy = 0.0, xz = 0.0, yz = 0.0;

    /// Adds weight * a a^T.
    void add(Vec3d a, double weight) {
        const Vec3d b = a * weight;
        xx += b.x * a.x;
        yy += b.y * a.y;
        zz += b.z * a.z;
        xy += b.x * a.y;
        xz += b.x * a.z;
        yz += b.y * a.z;
    }
};

struct EigenSystem {
    std::array<double, 3> values;  ///< ascending
    std::array<Vec3d, 3> vectors;  ///< unit length, one per value; signs are arbitrary
};

/// Small eigenvalues keep their digits, unlike with the closed form. The same bits on every
/// machine.
EigenSystem eigen_system(const SymmetricMatrix& matrix);

}  // namespace pointbake
