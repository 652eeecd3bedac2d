// [Hoppe92, 3.3]: signs spread along the minimum spanning tree of the neighbour graph, where an
// edge weighs 1 - |n_i . n_j|. It departs in two ways. The graph is not joined by a Euclidean
// spanning tree: each part gets a root of its own. The tree is never built: Kruskal's algorithm
// keeps with every union whether the two sides must be turned against each other.
#include "attributes/spanning_tree.h"

#include <algorithm>
#include <array>
#include <tuple>

#include "core/kdtree.h"
#include "core/parallel.h"
#include "core/parallel_sort.h"

namespace pointbake {
namespace {

constexpr std::size_t kEdgesPerPoint = 10;
constexpr std::size_t kGrain = 1024;             // points per chunk: about a millisecond
constexpr std::size_t kUnionsPerPoll = 1 << 16;  // edges between two looks at the stop token

struct Edge {
    float weight = 0.0F;
    Index a = kInvalidIndex, b = kInvalidIndex;  ///< a < b; kInvalidIndex = no edge

    friend bool operator<(const Edge& x, const Edge& y) {
        return std::tie(x.weight, x.a, x.b) < std::tie(y.weight, y.a, y.b);
    }
};

bool is_known(Vec3f normal) { return squared_length(normal) > 0.0F; }

Edge make_edge(std::span<const Vec3f> normals, Index i, Index j) {
    const float agreement = std::fabs(dot(normals[i], normals[j]));
    return {1.0F - agreement, std::min(i, j), std::max(i, j)};
}

std::vector<Edge> neighbor_edges(const PointCloud& cloud, const Context& context) {
    const KdTree tree(cloud.positions);
    const std::span<const Vec3f> normals = cloud.normals;
    std::vector<Edge> edges(cloud.size() * kEdgesPerPoint);
    parallel_for(context, cloud.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        std::array<Neighbor, kEdgesPerPoint + 1> buffer;
        for (std::size_t i = begin; i < end; ++i) {
            if (!is_known(normals[i])) continue;
            auto out = edges.begin() + static_cast<std::ptrdiff_t>(i * kEdgesPerPoint);
            const auto last = out + static_cast<std::ptrdiff_t>(kEdgesPerPoint);
            for (const Neighbor& neighbor : tree.nearest(cloud.positions[i], buffer))
                if (neighbor.index != i && out != last && is_known(normals[neighbor.index]))
                    *out++ = make_edge(normals, static_cast<Index>(i), neighbor.index);
        }
    });
    std::erase_if(edges, [](const Edge& e) { return e.a == kInvalidIndex; });
    return edges;
}

/// Disjoint sets whose members know whether they are turned against their set's root.
class TurnedSets {
 public:
    explicit TurnedSets(std::size_t count) : nodes_(count) {
        for (std::size_t i = 0; i < count; ++i) nodes_[i].parent = static_cast<Index>(i);
    }

    struct Place {
        Index root;
        bool is_turned;
    };
    Place find(Index i) {
        Place place{i, false};
        while (nodes_[place.root].parent != place.root) {
            place.is_turned ^= nodes_[place.root].is_turned;
            place.root = nodes_[place.root].parent;
        }
        compress(i, place);
        return place;
    }

    /// Joins the sets of a and b so that a and b are turned against each other, or not.
    void join(Index a, Index b, bool is_turned) {
        const Place pa = find(a), pb = find(b);
        if (pa.root == pb.root) return;
        nodes_[pb.root] = {pa.root, static_cast<bool>(pa.is_turned ^ pb.is_turned ^ is_turned)};
    }

 private:
    struct Node {
        Index parent = kInvalidIndex;
        bool is_turned = false;  ///< against the parent
    };

    void compress(Index i, Place place) {
        while (i != place.root) {
            const Node old = nodes_[i];
            nodes_[i] = {place.root, place.is_turned};
            place.is_turned ^= old.is_turned;
            i = old.parent;
        }
    }

    std::vector<Node> nodes_;
};

TurnedSets spanning_forest(const PointCloud& cloud, const Context& context) {
    std::vector<Edge> edges = neighbor_edges(cloud, context);
    parallel_sort(context, edges);
    TurnedSets sets(cloud.size());
    for (std::size_t e = 0; e < edges.size(); ++e) {
        if (e % kUnionsPerPoll == 0) check_cancelled(context);
        const auto [weight, a, b] = edges[e];
        sets.join(a, b, dot(cloud.normals[a], cloud.normals[b]) < 0.0F);
    }
    return sets;
}

/// Per set (at its root's index) the topmost point: the largest (z, y, x).
std::vector<Index> topmost_points(const PointCloud& cloud, TurnedSets& sets) {
    const auto height = [&](Index i) {
        const Vec3d p = cloud.positions[i];
        return std::tuple(p.z, p.y, p.x);
    };
    std::vector<Index> top(cloud.size(), kInvalidIndex);
    for (Index i = 0; i < cloud.size(); ++i) {
        Index& best = top[sets.find(i).root];
        if (best == kInvalidIndex || height(best) < height(i)) best = i;
    }
    return top;
}

}  // namespace

std::uint64_t orient_by_spanning_tree_in_place(PointCloud& cloud, const Context& context) {
    TurnedSets sets = spanning_forest(cloud, context);
    const std::vector<Index> top = topmost_points(cloud, sets);
    std::vector<char> turns_root(cloud.size(), 0);
    for (std::size_t r = 0; r < cloud.size(); ++r)
        if (top[r] != kInvalidIndex)
            turns_root[r] = sets.find(top[r]).is_turned ^ (cloud.normals[top[r]].z < 0.0F);

    std::uint64_t num_turned = 0;
    for (Index i = 0; i < cloud.size(); ++i) {
        const auto [root, is_turned] = sets.find(i);
        if ((turns_root[root] != 0) == is_turned || !is_known(cloud.normals[i])) continue;
        cloud.normals[i] = -cloud.normals[i];
        ++num_turned;
    }
    return num_turned;
}

}  // namespace pointbake
