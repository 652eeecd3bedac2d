// What the tests of this stage share: shuffled and random clouds, and measures of normals.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "core/hash.h"
#include "pointbake/error.h"
#include "support/shapes.h"

namespace pointbake {

/// Only the positions: what a file without attributes gives.
inline PointCloud bare(const PointCloud& cloud) {
    PointCloud result;
    result.positions = cloud.positions;
    return result;
}

/// The points (and normals) in another order: place i of the result holds point order[i].
inline std::vector<Index> shuffled_order(std::size_t count, std::uint64_t seed) {
    std::vector<Index> order(count);
    std::iota(order.begin(), order.end(), Index{0});
    std::sort(order.begin(), order.end(),
              [&](Index a, Index b) { return hash64(seed, a) < hash64(seed, b); });
    return order;
}

/// The plane's z = 0 unit square, points anywhere.
inline PointCloud random_square(std::size_t count, std::uint64_t seed) {
    PointCloud cloud;
    for (std::size_t i = 0; i < count; ++i)
        cloud.positions.push_back({random_unit(seed, 2 * i), random_unit(seed, 2 * i + 1), 0.0});
    return cloud;
}

/// |cosine| between two unit vectors.
inline double alignment(Vec3f a, Vec3f b) {
    return std::fabs(dot(vec_cast<double>(a), vec_cast<double>(b)));
}

/// Smallest |cosine| between the normals of two clouds.
inline double worst_alignment(const PointCloud& a, const PointCloud& b) {
    double worst = 1.0;
    for (std::size_t i = 0; i < a.size(); ++i)
        worst = std::min(worst, alignment(a.normals[i], b.normals[i]));
    return worst;
}

/// Share of normals on the same side as those of `truth`.
inline double agreement(const PointCloud& cloud, const PointCloud& truth) {
    std::size_t same = 0;
    for (std::size_t i = 0; i < cloud.size(); ++i)
        same += dot(cloud.normals[i], truth.normals[i]) > 0.0F ? 1U : 0U;
    return static_cast<double>(same) / static_cast<double>(cloud.size());
}

inline double sum_of_areas(const PointCloud& cloud) {
    double sum = 0.0;
    for (const float area : cloud.areas) sum += static_cast<double>(area);
    return sum;
}

inline double area(const Mesh& mesh) {
    double sum = 0.0;
    for (const Triangle& t : mesh.triangles) {
        const Vec3d a = mesh.positions[t[0]];
        sum += 0.5 * length(cross(mesh.positions[t[1]] - a, mesh.positions[t[2]] - a));
    }
    return sum;
}

template <class F>
void expect_error(ErrorCode code, F&& f) {
    try {
        f();
        ADD_FAILURE() << "no error";
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), code) << error.what();
    }
}

inline void expect_same_attributes(const PointCloud& a, const PointCloud& b) {
    EXPECT_EQ(a.normals, b.normals);
    EXPECT_EQ(a.areas, b.areas);
    EXPECT_EQ(a.radii, b.radii);
    ASSERT_EQ(a.axes.size(), b.axes.size());
    for (std::size_t i = 0; i < a.axes.size(); ++i) {
        ASSERT_EQ(a.axes[i].u, b.axes[i].u);
        ASSERT_EQ(a.axes[i].v, b.axes[i].v);
    }
}

}  // namespace pointbake
