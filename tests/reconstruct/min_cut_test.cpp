#include "reconstruct/min_cut.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/hash.h"

namespace pointbake {
namespace {

struct Graph {
    Index num_nodes = 0;
    std::vector<std::int64_t> terminals;
    struct Edge {
        Index a, b;
        std::int64_t capacity;
    };
    std::vector<Edge> edges;

    std::int64_t cost(const std::vector<bool>& is_source) const {
        std::int64_t sum = 0;
        for (Index i = 0; i < num_nodes; ++i)
            if ((terminals[i] > 0) != is_source[i]) sum += std::abs(terminals[i]);
        for (const Edge& e : edges)
            if (is_source[e.a] != is_source[e.b]) sum += e.capacity;
        return sum;
    }
};

Graph random_graph(Index num_nodes, Index num_edges, std::uint64_t seed) {
    Graph g;
    g.num_nodes = num_nodes;
    for (Index i = 0; i < num_nodes; ++i)
        g.terminals.push_back(static_cast<std::int64_t>(hash64(seed, i) % 41) - 20);
    for (Index e = 0; e < num_edges; ++e) {
        const auto h = hash64(seed + 1000, e);
        const auto a = static_cast<Index>(h % num_nodes);
        const auto b = static_cast<Index>((h >> 20) % num_nodes);
        if (a != b) g.edges.push_back({a, b, static_cast<std::int64_t>((h >> 40) % 20)});
    }
    return g;
}

std::vector<bool> solve(const Graph& g) {
    MinCut cut(g.num_nodes);
    for (Index i = 0; i < g.num_nodes; ++i) cut.add_terminal(i, g.terminals[i]);
    for (const auto& e : g.edges) cut.add_edge(e.a, e.b, e.capacity);
    cut.solve({});
    std::vector<bool> is_source(g.num_nodes);
    for (Index i = 0; i < g.num_nodes; ++i) is_source[i] = cut.is_source(i);
    return is_source;
}

TEST(MinCut, CutsAChainAtItsWeakestLink) {
    Graph g{5, {100, 0, 0, 0, -100}, {{0, 1, 9}, {1, 2, 3}, {2, 3, 8}, {3, 4, 7}}};
    EXPECT_EQ(solve(g), (std::vector<bool>{true, true, false, false, false}));
}

TEST(MinCut, CostsAsLittleAsTheBestOfAllCuts) {
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
        const Graph g = random_graph(10, 25, seed);
        std::int64_t best = std::numeric_limits<std::int64_t>::max();
        for (unsigned bits = 0; bits < 1U << g.num_nodes; ++bits) {
            std::vector<bool> is_source(g.num_nodes);
            for (Index i = 0; i < g.num_nodes; ++i) is_source[i] = (bits >> i & 1U) != 0;
            best = std::min(best, g.cost(is_source));
        }
        EXPECT_EQ(g.cost(solve(g)), best) << "seed " << seed;
    }
}

TEST(MinCut, NoSingleFlipLowersTheCostOfALargeCut) {
    const Graph g = random_graph(3000, 12000, 7);
    std::vector<bool> is_source = solve(g);
    const std::int64_t cost = g.cost(is_source);
    for (Index i = 0; i < g.num_nodes; i += 37) {
        is_source[i] = !is_source[i];
        EXPECT_GE(g.cost(is_source), cost);
        is_source[i] = !is_source[i];
    }
}

}  // namespace
}  // namespace pointbake
