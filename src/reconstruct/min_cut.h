// Minimum cut of a graph between two terminals.
#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "pointbake/context.h"
#include "pointbake/types.h"

namespace pointbake {

/// Integer capacities: the cut is exact and the same on every machine. Fast where most nodes are
/// near a terminal.
class MinCut {
 public:
    explicit MinCut(std::size_t num_nodes);
    /// Ties a node to the source (positive) or the sink (negative); adds up.
    void add_terminal(Index node, std::int64_t capacity) { nodes_[node].terminal += capacity; }
    /// Joins two nodes by the same capacity both ways.
    void add_edge(Index a, Index b, std::int64_t capacity);
    void solve(const Context& context);
    /// After solve(); nodes that no terminal reaches are on neither side.
    bool is_source(Index node) const { return nodes_[node].tree == kSource; }
    bool is_sink(Index node) const { return nodes_[node].tree == kSink; }

 private:
    enum Tree : std::int8_t { kFree, kSource, kSink };
    static constexpr Index kNoArc = kInvalidIndex, kTerminal = kInvalidIndex - 1,
                           kOrphan = kInvalidIndex - 2;
    struct Node {
        std::int64_t terminal =
            0;                  ///< residual capacity from the source, or, negative, to the sink
        Index first = kNoArc;   ///< first arc
        Index parent = kNoArc;  ///< arc to the parent in the tree
        Index stamp = 0, distance = 0;
        Tree tree = kFree;
        bool is_active = false;
    };
    struct Arc {
        Index head, next;
        std::int64_t residual;
    };

    /// Residual capacity along an arc from a node of this tree to its neighbour, in flow's
    /// direction.
    std::int64_t& outward(Index arc, Tree tree) {
        return arcs_[tree == kSource ? arc : arc ^ 1].residual;
    }
    void activate(Index node);
    void attach(Index node, Index parent_arc, Tree tree, Index distance);
    Index grow(Index node);
    void augment(Index bridge);
    std::int64_t bottleneck(Index node, std::int64_t flow);
    void push(Index node, std::int64_t flow);
    void orphan(Index node);
    void adopt();
    void adopt_one(Index node);
    Index distance_to_root(Index node);

    std::vector<Node> nodes_;
    std::vector<Arc> arcs_;
    std::deque<Index> active_, orphans_;
    Index time_ = 0;
};

}  // namespace pointbake
