// Open surfaces: how far they go from the points, and what their borders look like.
#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>

#include "core/adjacency.h"
#include "core/kdtree.h"
#include "core/parallel.h"
#include "pointbake/denoise.h"
#include "pointbake/error.h"
#include "pointbake/load.h"
#include "pointbake/reconstruct.h"
#include "support/shapes.h"

namespace pointbake {
namespace {

double distance_to_segment(Vec3d p, Vec3d a, Vec3d b) {
    const Vec3d d = b - a;
    const double t = std::clamp(dot(p - a, d) / squared_length(d), 0.0, 1.0);
    return length(p - (a + d * t));
}

// sqrt(pi d^2 / 12), d the distance to the 12th nearest other point.
std::vector<double> spacings_of(const PointCloud& cloud, const KdTree& tree) {
    std::vector<double> spacings(cloud.size());
    parallel_for({}, cloud.size(), 1024, [&](std::size_t begin, std::size_t end) {
        std::array<Neighbor, 13> found;
        for (std::size_t i = begin; i < end; ++i)
            spacings[i] =
                std::sqrt(std::numbers::pi / 12.0 *
                          tree.nearest(cloud.positions[i], found).back().squared_distance);
    });
    return spacings;
}

struct Figures {
    double farthest = 0.0;                            // from the nearest point, in its spacings
    double highest_tooth = 0.0, deepest_notch = 0.0;  // in spacings
    int num_far = 0, num_teeth = 0, num_notches = 0, num_border = 0;
    double area = 0.0;
};

class Measure {
 public:
    Measure(const PointCloud& cloud, const DenseMesh& surface)
        : cloud_(cloud),
          mesh_(surface.mesh),
          points_of_(surface.vertex_points),
          tree_(cloud.positions),
          spacings_(spacings_of(cloud, tree_)) {}

    Figures run() {
        for (const Triangle& t : mesh_.triangles) figures_.area += 0.5 * length(area_vector(t));
        measure_distances();
        measure_borders();
        return figures_;
    }

 private:
    Vec3d area_vector(const Triangle& t) const {
        const auto& p = mesh_.positions;
        return cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]);
    }

    // Where points become denser all of a sudden, those of a corner count up to 1.5 times.
    double far(Vec3d x, const Triangle& t) const {
        Neighbor nearest;
        tree_.nearest(x, std::span(&nearest, 1));
        const double own = spacings_[nearest.index];
        const double corners = std::max({spacing_at(t[0]), spacing_at(t[1]), spacing_at(t[2])});
        return std::sqrt(nearest.squared_distance) / std::max(own, std::min(1.5 * own, corners));
    }

    // Of triangles some way from their corners: a grid of places with the corners, the middles of
    // the edges and the centre in it.
    void measure_distances() {
        std::vector<double> farthest(mesh_.triangles.size());
        parallel_for({}, farthest.size(), 64, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const Triangle& t = mesh_.triangles[i];
                const Vec3d a = mesh_.positions[t[0]], b = mesh_.positions[t[1]] - a,
                            c = mesh_.positions[t[2]] - a;
                const double longest = std::sqrt(
                    std::max({squared_length(b), squared_length(c), squared_length(c - b)}));
                const double least =
                    std::min({spacing_at(t[0]), spacing_at(t[1]), spacing_at(t[2])});
                const int steps =
                    std::clamp(static_cast<int>(6.0 * longest / least), 2, 24) / 2 * 2;
                for (int j = 0; j <= steps; ++j)
                    for (int k = 0; j + k <= steps; ++k)
                        farthest[i] =
                            std::max(farthest[i],
                                     far(a + b * (j / double(steps)) + c * (k / double(steps)), t));
            }
        });
        for (const double f : farthest) {
            figures_.farthest = std::max(figures_.farthest, f);
            figures_.num_far += f > 3.0 ? 1 : 0;
        }
    }

    double spacing_at(Index v) const { return spacings_[points_of_[v]]; }

    void measure_borders() {
        const auto neighbors = triangle_neighbors(mesh_.triangles);
        const std::size_t n = mesh_.positions.size();
        std::vector<Index> next(n, kInvalidIndex), before(n, kInvalidIndex), count(n, 0), behind(n);
        for (Index t = 0; t < mesh_.triangles.size(); ++t) {
            for (std::size_t k = 0; k < 3; ++k) {
                const Index a = mesh_.triangles[t][k], b = mesh_.triangles[t][(k + 1) % 3];
                ++count[a];
                if (neighbors[t][k] == kInvalidIndex) next[a] = b, before[b] = a, behind[a] = t;
            }
        }
        for (Index v = 0; v < n; ++v) {
            if (next[v] == kInvalidIndex) continue;
            ++figures_.num_border;
            const Vec3d p = mesh_.positions[v], a = mesh_.positions[before[v]],
                        b = mesh_.positions[next[v]];
            const double depth = distance_to_segment(p, a, b) / spacing_at(v);
            const bool is_tooth = count[v] == 1;
            // Along the border the surface is to the left of it.
            if (!is_tooth && !is_notch({v, before[v], next[v]}, behind[before[v]], behind[v]))
                continue;
            double& largest = is_tooth ? figures_.highest_tooth : figures_.deepest_notch;
            largest = std::max(largest, depth);
            (is_tooth ? figures_.num_teeth : figures_.num_notches) += depth > 1.0 ? 1 : 0;
        }
    }

    // Whether a triangle could lie there: the surface goes on at less than 45 degrees from both
    // triangles, not onto other vertices, near the points. Else it is a corner or the end of a gap.
    bool is_notch(const Triangle& t, Index first, Index second) const {
        const Vec3d own = area_vector(t);
        for (const Index other : {first, second})
            if (dot(normalized(own), normalized(area_vector(mesh_.triangles[other]))) < 0.70711)
                return false;
        const auto& p = mesh_.positions;
        const Vec3d center = (p[t[0]] + p[t[1]] + p[t[2]]) / 3.0;
        for (int j = 0; j <= 10; ++j)
            for (int k = 0; j + k <= 10; ++k)
                if (far(p[t[0]] + (p[t[1]] - p[t[0]]) * (j / 10.0) +
                            (p[t[2]] - p[t[0]]) * (k / 10.0),
                        t) > 2.75)
                    return false;
        std::array<Neighbor, 64> buffer;
        for (const Neighbor& near : tree_.nearest(center, buffer)) {
            const Vec3d x = cloud_.positions[near.index];
            bool inside = true;
            for (std::size_t k = 0; k < 3; ++k)
                inside &= dot(cross(p[t[(k + 1) % 3]] - p[t[k]], x - p[t[k]]), own) > 0.0;
            if (inside) return false;
        }
        return true;
    }

    const PointCloud& cloud_;
    const Mesh& mesh_;
    std::span<const Index> points_of_;
    KdTree tree_;
    std::vector<double> spacings_;
    Figures figures_;
};

Figures measure(const char* name, const PointCloud& cloud) {
    const ReconstructResult r = reconstruct(cloud, {.surface = Surface::kOpen});
    const Topology t = topology(r.surface.mesh.positions.size(), r.surface.mesh.triangles);
    EXPECT_EQ(t.num_nonmanifold_edges + t.num_nonmanifold_vertices, 0U) << name;
    const Figures f = Measure(cloud, r.surface).run();
    std::printf(
        "%s: %zu points, %u unused, %u borders of %d edges; farthest %.2f (%d); teeth %d of up to "
        "%.2f, notches "
        "%d of up to %.2f; area %.6g\n",
        name, cloud.size(), r.report.num_unused, t.num_boundary_loops, f.num_border, f.farthest,
        f.num_far, f.num_teeth, f.highest_tooth, f.num_notches, f.deepest_notch, f.area);
    return f;
}

PointCloud random_square(std::uint64_t n) {
    PointCloud cloud;
    for (std::uint64_t i = 0; i < n; ++i)
        shapes::add_point(cloud, {random_unit(21, i), random_unit(22, i), 0.0}, {0, 0, 1});
    return cloud;
}

PointCloud random_half_sphere(std::uint64_t n) {
    PointCloud cloud;
    for (std::uint64_t i = 0; i < n; ++i) {
        const double z = random_unit(23, i), a = 2.0 * std::numbers::pi * random_unit(24, i);
        const double r = std::sqrt(1.0 - z * z);
        const Vec3d p{r * std::cos(a), r * std::sin(a), z};
        shapes::add_point(cloud, p, p);
    }
    return cloud;
}

void expect_clean(const Figures& f, double area) {
    EXPECT_LE(f.farthest, 3.0);
    EXPECT_LE(f.highest_tooth, 1.0);
    EXPECT_LE(f.deepest_notch, 1.0);
    if (area > 0.0) {
        EXPECT_NEAR(f.area, area, 0.01 * area);
    }
}

TEST(Borders, OfARandomSquareAreClean) {
    expect_clean(measure("square", random_square(20000)), 1.0);
}

TEST(Borders, OfARandomHalfSphereAreClean) {
    expect_clean(measure("half sphere", random_half_sphere(20000)), 2.0 * std::numbers::pi);
}

PointCloud square_with_hole(double radius) {
    PointCloud cloud = random_square(20000);
    std::vector<Vec3d> kept;
    for (const Vec3d& p : cloud.positions)
        if (length(p - Vec3d{0.5, 0.5, 0.0}) > radius) kept.push_back(p);
    PointCloud holed;
    for (const Vec3d& p : kept) shapes::add_point(holed, p, {0, 0, 1});
    return holed;
}

TEST(FillHoles, FillsThoseOfTheSizeThatIsGiven) {
    const PointCloud cloud = square_with_hole(0.15);
    const auto loops = [&](std::optional<Length> size, Method method = Method::kAuto) {
        PointCloud with_areas = cloud;
        with_areas.areas.assign(cloud.size(), 1.0F / 20000.0F);
        const ReconstructResult r = reconstruct(
            with_areas, {.surface = Surface::kOpen, .method = method, .fill_holes = size});
        const Topology t = topology(r.surface.mesh.positions.size(), r.surface.mesh.triangles);
        EXPECT_EQ(t.num_nonmanifold_edges + t.num_nonmanifold_vertices, 0U);
        return std::pair(r.report.num_boundary_loops, r.report.num_holes_filled);
    };
    // The points are random: Cocone leaves a few gaps beside the hole.
    const auto [num_left, num_gaps] = loops({});
    EXPECT_EQ(num_left, 2U);
    EXPECT_EQ(loops(units(0.0)), std::pair(2U + num_gaps, 0U));
    EXPECT_EQ(loops(units(0.25)), std::pair(2U, num_gaps));
    EXPECT_EQ(loops(units(0.35)), std::pair(1U, num_gaps + 1U));
    EXPECT_EQ(loops(fraction(100.0)), std::pair(1U, num_gaps + 1U));  // but never its rim
    // The cut of an implicit surface leaves a few small holes, too.
    EXPECT_LT(loops(units(0.25), Method::kImplicit).first, loops({}, Method::kImplicit).first);
}

TEST(FillHoles, NeedsALength) {
    for (const double size : {-1.0, HUGE_VAL, std::nan("")}) {
        EXPECT_THROW(reconstruct(random_square(50), {.fill_holes = units(size)}), Error);
    }
}

class RealClouds : public testing::TestWithParam<const char*> {};

TEST_P(RealClouds, StayNearTheirPoints) {
    const std::filesystem::path path = std::filesystem::path(POINTBAKE_TEST_DATA) / GetParam();
    if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there: nothing tested";
    // As in a conversion: noise is measured, and taken out.
    const Figures f = measure(GetParam(), denoise(load_cloud(path).cloud).cloud);
    EXPECT_LE(f.farthest, 3.0);
    EXPECT_LE(f.highest_tooth, 1.0);
    EXPECT_LE(100 * f.num_notches, f.num_border);  // held by what lies above or below
}

INSTANTIATE_TEST_SUITE_P(Borders, RealClouds,
                         testing::Values("colored_points/o3d_livingroom_002.ply",
                                         "colored_points/pump.ply",
                                         "colored_points/lion_takanawa.ply",
                                         "colored_points/pond_surfels.ply"));

}  // namespace
}  // namespace pointbake
