#include "reconstruct/simplex_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "core/hash.h"

namespace pointbake {
namespace {

using Tet = std::array<Index, 4>;

void split_random_child(SimplexGrid& grid, std::uint64_t k) {
    std::vector<SimplexGrid::Point> children;
    grid.for_each_child(static_cast<Index>(k % grid.num_nodes()),
                        [&](const auto& p) { children.push_back(p); });
    if (!children.empty()) grid.split(children[hash64(k) % children.size()]);
}

// Splits pseudo-random edges, preferably near one place.
SimplexGrid random_grid(std::uint64_t seed, int num_splits) {
    SimplexGrid grid({-1, 2, 3}, 2.0, {2, 1, 1});
    for (int i = 0; i < num_splits; ++i) {
        std::uint64_t k = hash64(seed, static_cast<std::uint64_t>(i)) % grid.num_nodes();
        if (i % 2) k = grid.num_nodes() - 1 - k % std::min<std::uint64_t>(20, grid.num_nodes());
        split_random_child(grid, k);
    }
    return grid;
}

std::vector<Tet> all_leaves(const SimplexGrid& grid) {
    return grid.leaves({}, [](const Tet&) { return true; });
}

TEST(SimplexGrid, FillsTheCubesWithoutHangingNodes) {
    for (std::uint64_t seed = 0; seed < 5; ++seed) {
        const SimplexGrid grid = random_grid(seed, 300);
        std::int64_t volume = 0;
        std::map<std::array<Index, 3>, int> faces;
        for (const Tet& t : all_leaves(grid)) {
            const std::int64_t v = grid.orientation(t);
            EXPECT_NE(v, 0);
            volume += std::abs(v);
            for (std::size_t k = 0; k < 4; ++k) {
                std::array<Index, 3> face{t[(k + 1) % 4], t[(k + 2) % 4], t[(k + 3) % 4]};
                std::ranges::sort(face);
                ++faces[face];
            }
        }
        EXPECT_EQ(volume, 6 * 2 * (std::int64_t{1} << 3 * SimplexGrid::kDepth));
        for (const auto& [face, count] : faces) {
            if (count == 2) continue;
            EXPECT_EQ(count, 1);
            for (const Index v : face) EXPECT_TRUE(grid.is_on_boundary(v));
        }
    }
}

TEST(SimplexGrid, TetrahedraStayWellShaped) {
    const SimplexGrid grid = random_grid(7, 500);
    for (const Tet& t : all_leaves(grid)) {
        double longest2 = 0.0;
        for (const Index a : t)
            for (const Index b : t)
                longest2 = std::max(longest2, squared_length(grid.place(a) - grid.place(b)));
        const Vec3d p = grid.place(t[0]);
        const double volume6 =
            std::abs(dot(grid.place(t[1]) - p, cross(grid.place(t[2]) - p, grid.place(t[3]) - p)));
        // The three shapes: l^3 / (3 sqrt(3)), l^3 / (4 sqrt(2)), l^3 / 4.
        EXPECT_GE(volume6, 0.17 * longest2 * std::sqrt(longest2));
    }
}

TEST(SimplexGrid, NodesAreTheMiddlesOfTheirEdges) {
    const SimplexGrid grid = random_grid(3, 300);
    for (Index node = 0; node < grid.num_nodes(); ++node) {
        if (grid.is_corner(node)) continue;
        const auto [a, b] = grid.edge(grid.point(node));
        ASSERT_NE(a, kInvalidIndex);
        ASSERT_NE(b, kInvalidIndex);
        EXPECT_GT(grid.level(node), std::max(grid.level(a), grid.level(b)));
        EXPECT_EQ(length((grid.place(a) + grid.place(b)) * 0.5 - grid.place(node)), 0.0);
        EXPECT_NEAR(length(grid.place(a) - grid.place(b)), grid.edge_length(grid.point(node)),
                    1e-12);
    }
}

TEST(SimplexGrid, DoesNotDependOnTheOrderOfSplits) {
    SimplexGrid a({0, 0, 0}, 1.0, {1, 1, 1});
    for (std::uint64_t i = 0; i < 200; ++i) split_random_child(a, hash64(5, i));
    std::vector<SimplexGrid::Point> wanted;
    for (Index node = 0; node < a.num_nodes(); ++node)
        if (!a.is_corner(node)) wanted.push_back(a.point(node));
    // The same nodes, the last first.
    SimplexGrid b({0, 0, 0}, 1.0, {1, 1, 1});
    for (; !wanted.empty(); wanted.pop_back()) b.split(wanted.back());
    const auto places = [](const SimplexGrid& grid) {
        std::vector<std::array<SimplexGrid::Point, 4>> out;
        for (const Tet& t : all_leaves(grid))
            out.push_back({grid.point(t[0]), grid.point(t[1]), grid.point(t[2]), grid.point(t[3])});
        return out;
    };
    EXPECT_EQ(places(a), places(b));
}

}  // namespace
}  // namespace pointbake
