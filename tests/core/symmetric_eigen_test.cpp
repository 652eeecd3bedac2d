#include "core/symmetric_eigen.h"

#include <gtest/gtest.h>

#include "core/hash.h"

namespace pointbake {
namespace {

Vec3d multiply(const SymmetricMatrix& m, Vec3d a) {
    return {m.xx * a.x + m.xy * a.y + m.xz * a.z, m.xy * a.x + m.yy * a.y + m.yz * a.z,
            m.xz * a.x + m.yz * a.y + m.zz * a.z};
}

SymmetricMatrix random_matrix(std::uint64_t seed, double flatness) {
    SymmetricMatrix m;
    for (std::uint64_t i = 0; i < 5; ++i) {
        Vec3d a;
        for (std::size_t k = 0; k < 3; ++k) a[k] = random_unit(seed, 3 * i + k) - 0.5;
        a.z = a.z * flatness + a.x - a.y;
        m.add(a, 1.0);
    }
    return m;
}

TEST(SymmetricEigen, VectorsAreOrthonormalAndStretchedByTheirValues) {
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
        const SymmetricMatrix m = random_matrix(seed, 1.0);
        const EigenSystem e = eigen_system(m);
        EXPECT_LE(e.values[0], e.values[1]);
        EXPECT_LE(e.values[1], e.values[2]);
        for (std::size_t i = 0; i < 3; ++i) {
            const Vec3d off = multiply(m, e.vectors[i]) - e.vectors[i] * e.values[i];
            EXPECT_LT(length(off), 1e-14 * e.values[2]);
            for (std::size_t j = 0; j < 3; ++j)
                EXPECT_NEAR(dot(e.vectors[i], e.vectors[j]), i == j ? 1.0 : 0.0, 1e-14);
        }
    }
}

TEST(SymmetricEigen, FindsTheNormalOfNearlyFlatNeighborhoods) {
    for (std::uint64_t seed = 0; seed < 50; ++seed) {
        const EigenSystem e = eigen_system(random_matrix(seed, 1e-9));
        const Vec3d normal = normalized(Vec3d{1.0, -1.0, -1.0});
        EXPECT_GT(std::fabs(dot(e.vectors[0], normal)), 1.0 - 1e-14);
    }
}

TEST(SymmetricEigen, TakesDiagonalAndZeroMatrices) {
    const EigenSystem e = eigen_system({.xx = 3.0, .yy = 1.0, .zz = 2.0});
    EXPECT_EQ(e.values, (std::array{1.0, 2.0, 3.0}));
    EXPECT_EQ(e.vectors[0], (Vec3d{0.0, 1.0, 0.0}));
    EXPECT_EQ(e.vectors[2], (Vec3d{1.0, 0.0, 0.0}));
    EXPECT_EQ(eigen_system({}).values, (std::array{0.0, 0.0, 0.0}));
}

}  // namespace
}  // namespace pointbake
