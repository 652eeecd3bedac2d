// Based on [Boykov04]: a search tree from each terminal, kept from one augmentation to the next.
#include "reconstruct/min_cut.h"

#include <algorithm>

#include "core/parallel.h"

namespace pointbake {
namespace {

constexpr std::size_t kPollInterval = 1U << 14;
constexpr Index kNoDistance = kInvalidIndex;

}  // namespace

MinCut::MinCut(std::size_t num_nodes) : nodes_(num_nodes) {}

void MinCut::add_edge(Index a, Index b, std::int64_t capacity) {
    const auto arc = static_cast<Index>(arcs_.size());
    arcs_.push_back({b, nodes_[a].first, capacity});
    arcs_.push_back({a, nodes_[b].first, capacity});
    nodes_[a].first = arc;
    nodes_[b].first = arc + 1;
}

void MinCut::activate(Index node) {
    if (nodes_[node].is_active) return;
    nodes_[node].is_active = true;
    active_.push_back(node);
}

void MinCut::attach(Index node, Index parent_arc, Tree tree, Index distance) {
    Node& n = nodes_[node];
    n.tree = tree, n.parent = parent_arc, n.stamp = time_, n.distance = distance;
}

void MinCut::solve(const Context& context) {
    for (Index i = 0; i < nodes_.size(); ++i) {
        if (nodes_[i].terminal == 0) continue;
        attach(i, kTerminal, nodes_[i].terminal > 0 ? kSource : kSink, 1);
        activate(i);
    }
    for (std::size_t step = 0; !active_.empty(); ++step) {
        if (step % kPollInterval == 0) check_cancelled(context);
        const Index i = active_.front();
        const Index bridge = nodes_[i].parent == kNoArc ? kNoArc : grow(i);
        if (bridge == kNoArc) {
            active_.pop_front();
            nodes_[i].is_active = false;
            continue;
        }
        ++time_;
        augment(bridge);
        adopt();
    }
}

// Takes free neighbours into the node's tree. Returns an arc from the source's tree to the sink's
// if they meet.
Index MinCut::grow(Index i) {
    const Tree tree = nodes_[i].tree;
    for (Index a = nodes_[i].first; a != kNoArc; a = arcs_[a].next) {
        if (outward(a, tree) == 0) continue;
        const Index j = arcs_[a].head;
        Node& n = nodes_[j];
        if (n.parent == kNoArc) {
            attach(j, a ^ 1, tree, nodes_[i].distance + 1);
            n.stamp = nodes_[i].stamp;
            activate(j);
        } else if (n.tree != tree) {
            return tree == kSource ? a : a ^ 1;
        } else if (n.stamp <= nodes_[i].stamp && n.distance > nodes_[i].distance + 1) {
            attach(j, a ^ 1, tree, nodes_[i].distance + 1);  // a shorter way to the root
            n.stamp = nodes_[i].stamp;
        }
    }
    return kNoArc;
}

std::int64_t MinCut::bottleneck(Index node, std::int64_t flow) {
    const Tree tree = nodes_[node].tree;
    while (nodes_[node].parent != kTerminal) {
        const Index to_parent = nodes_[node].parent;
        flow = std::min(flow, outward(to_parent ^ 1, tree));
        node = arcs_[to_parent].head;
    }
    return std::min(flow, std::abs(nodes_[node].terminal));
}

void MinCut::push(Index node, std::int64_t flow) {
    const Tree tree = nodes_[node].tree;
    while (nodes_[node].parent != kTerminal) {
        const Index to_parent = nodes_[node].parent;
        outward(to_parent, tree) += flow;
        outward(to_parent ^ 1, tree) -= flow;
        const Index next = arcs_[to_parent].head;
        if (outward(to_parent ^ 1, tree) == 0) orphan(node);
        node = next;
    }
    nodes_[node].terminal -= tree == kSource ? flow : -flow;
    if (nodes_[node].terminal == 0) orphan(node);
}

void MinCut::augment(Index bridge) {
    const Index from = arcs_[bridge ^ 1].head, to = arcs_[bridge].head;
    const std::int64_t flow = bottleneck(to, bottleneck(from, arcs_[bridge].residual));
    arcs_[bridge].residual -= flow;
    arcs_[bridge ^ 1].residual += flow;
    push(from, flow);
    push(to, flow);
}

void MinCut::orphan(Index node) {
    nodes_[node].parent = kOrphan;
    orphans_.push_back(node);
}

void MinCut::adopt() {
    while (!orphans_.empty()) {
        const Index i = orphans_.front();
        orphans_.pop_front();
        adopt_one(i);
    }
}

// Steps from a node to a terminal, kNoDistance if an orphan lies on the way. Leaves what it learns
// along the way.
Index MinCut::distance_to_root(Index node) {
    Index steps = 0, j = node;
    for (;; j = arcs_[nodes_[j].parent].head) {
        if (nodes_[j].stamp == time_) {
            steps += nodes_[j].distance;
            break;
        }
        ++steps;
        if (nodes_[j].parent == kTerminal) {
            nodes_[j].stamp = time_, nodes_[j].distance = 1;
            break;
        }
        if (nodes_[j].parent == kOrphan || nodes_[j].parent == kNoArc) return kNoDistance;
    }
    Index left = steps;
    for (j = node; nodes_[j].stamp != time_; j = arcs_[nodes_[j].parent].head) {
        nodes_[j].stamp = time_;
        nodes_[j].distance = left--;
    }
    return steps;
}

// Finds a new parent in the same tree; without one the node becomes free and its children orphans.
void MinCut::adopt_one(Index i) {
    const Tree tree = nodes_[i].tree;
    Index best = kNoArc, best_distance = kNoDistance;
    for (Index a = nodes_[i].first; a != kNoArc; a = arcs_[a].next) {
        const Index j = arcs_[a].head;
        if (outward(a ^ 1, tree) == 0 || nodes_[j].tree != tree || nodes_[j].parent == kNoArc)
            continue;
        const Index distance = distance_to_root(j);
        if (distance < best_distance) best = a, best_distance = distance;
    }
    if (best != kNoArc) return attach(i, best, tree, best_distance + 1);
    for (Index a = nodes_[i].first; a != kNoArc; a = arcs_[a].next) {
        const Index j = arcs_[a].head;
        if (nodes_[j].tree != tree || nodes_[j].parent == kNoArc) continue;
        if (outward(a ^ 1, tree) > 0) activate(j);
        const Index p = nodes_[j].parent;
        if (p != kTerminal && p != kOrphan && arcs_[p].head == i) orphan(j);
    }
    nodes_[i].parent = kNoArc;
    nodes_[i].tree = kFree;
}

}  // namespace pointbake
