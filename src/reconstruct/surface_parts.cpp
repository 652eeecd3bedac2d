#include "reconstruct/surface_parts.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <numeric>
#include <utility>
#include <vector>

#include "core/adjacency.h"
#include "core/union_find.h"

namespace pointbake {
namespace {

// Smaller islands are left over from noise.
constexpr Index kLeastTriangles = 12;
constexpr double kLeastSupport = 0.1;
// Enough for the grid's steps to vanish.
constexpr int kSmoothingSteps = 30;

/// Without vertices that no triangle uses.
Mesh compact(const Mesh& mesh) {
    std::vector<Index> index(mesh.positions.size(), kInvalidIndex);
    for (const Triangle& t : mesh.triangles)
        for (const Index v : t) index[v] = 0;
    Mesh out;
    for (Index v = 0; v < index.size(); ++v) {
        if (index[v] == kInvalidIndex) continue;
        index[v] = static_cast<Index>(out.positions.size());
        out.positions.push_back(mesh.positions[v]);
    }
    for (const Triangle& t : mesh.triangles)
        out.triangles.push_back({index[t[0]], index[t[1]], index[t[2]]});
    return out;
}

/// A set per vertex: its piece.
UnionFind find_vertex_pieces(const Mesh& mesh) {
    UnionFind pieces(mesh.positions.size());
    for (const Triangle& t : mesh.triangles) {
        pieces.unite(t[0], t[1]);
        pieces.unite(t[0], t[2]);
    }
    return pieces;
}

class Cutter {
 public:
    Cutter(const Mesh& mesh, std::span<const float> support) : support_(support) {
        out_.positions = mesh.positions;
        for (const Triangle& t : mesh.triangles) cut(t);
    }
    Mesh take() { return std::move(out_); }

 private:
    void cut(Triangle t) {
        const auto is_in = [&](Index v) { return support_[v] > 0.0F; };
        const int count = is_in(t[0]) + is_in(t[1]) + is_in(t[2]);
        if (count == 0) return;
        if (count == 3) {
            out_.triangles.push_back(t);
            return;
        }
        // The corner that is alone comes first.
        while (is_in(t[0]) != (count == 1)) std::rotate(t.begin(), t.begin() + 1, t.end());
        const Index p = crossing(t[0], t[1]), q = crossing(t[0], t[2]);
        if (count == 1) {
            out_.triangles.push_back({t[0], p, q});
        } else {
            out_.triangles.push_back({p, t[1], t[2]});
            out_.triangles.push_back({p, t[2], q});
        }
    }

    Index crossing(Index a, Index b) {
        if (a > b) std::swap(a, b);
        const auto [at, is_new] =
            crossings_.try_emplace({a, b}, static_cast<Index>(out_.positions.size()));
        if (is_new) {
            const double t = support_[a] / (double{support_[a]} - support_[b]);
            out_.positions.push_back(out_.positions[a] +
                                     (out_.positions[b] - out_.positions[a]) * t);
        }
        return at->second;
    }

    std::span<const float> support_;
    Mesh out_;
    std::map<std::array<Index, 2>, Index> crossings_;
};

void drop_small_pieces(Mesh& mesh) {
    UnionFind pieces = find_vertex_pieces(mesh);
    std::vector<Index> count(mesh.positions.size());
    for (const Triangle& t : mesh.triangles) ++count[pieces.find(t[0])];
    std::erase_if(mesh.triangles,
                  [&](const Triangle& t) { return count[pieces.find(t[0])] < kLeastTriangles; });
}

/// Gives each fan of triangles around a vertex a vertex of its own.
void split_pinches(Mesh& mesh) {
    const auto neighbors = triangle_neighbors(mesh.triangles);
    UnionFind fans(3 * mesh.triangles.size());
    for (Index t = 0; t < mesh.triangles.size(); ++t)
        for (Index k = 0; k < 3; ++k) {
            const Index other = neighbors[t][k];
            if (other == kInvalidIndex) continue;
            for (const Index c : {k, (k + 1) % 3})
                for (Index d = 0; d < 3; ++d)
                    if (mesh.triangles[other][d] == mesh.triangles[t][c])
                        fans.unite(3 * t + c, 3 * other + d);
        }
    std::vector<Index> owner(mesh.positions.size(), kInvalidIndex);
    std::vector<Index> vertex(fans.size(), kInvalidIndex);
    for (Index corner = 0; corner < fans.size(); ++corner) {
        Index& v = mesh.triangles[corner / 3][corner % 3];
        const Index fan = fans.find(corner);
        if (vertex[fan] == kInvalidIndex) {
            vertex[fan] = v;
            if (owner[v] != kInvalidIndex) {
                vertex[fan] = static_cast<Index>(mesh.positions.size());
                mesh.positions.push_back(mesh.positions[v]);
            } else {
                owner[v] = fan;
            }
        }
        v = vertex[fan];
    }
}

}  // namespace

void smooth_unsupported_in_place(Mesh& mesh, std::span<const float> support) {
    const auto is_free = [&](Index v) { return support[v] <= 0.0F; };
    std::vector<Triangle> triangles;
    std::ranges::copy_if(mesh.triangles, std::back_inserter(triangles), [&](const Triangle& t) {
        return is_free(t[0]) || is_free(t[1]) || is_free(t[2]);
    });
    std::vector<Vec3d> sum(mesh.positions.size());
    std::vector<Index> count(mesh.positions.size());
    for (int step = 0; step < kSmoothingSteps; ++step) {
        for (const Triangle& t : triangles)
            for (std::size_t k = 0; k < 3; ++k) {
                sum[t[k]] += mesh.positions[t[(k + 1) % 3]];
                ++count[t[k]];
            }
        for (const Triangle& t : triangles)
            for (const Index v : t) {
                if (is_free(v) && count[v] > 0)
                    mesh.positions[v] = sum[v] / static_cast<double>(count[v]);
                sum[v] = {};
                count[v] = 0;
            }
    }
}

Mesh trim(const Mesh& mesh, std::span<const float> support) {
    Mesh out = Cutter(mesh, support).take();
    split_pinches(out);
    drop_small_pieces(out);
    return compact(out);
}

Mesh keep_supported_pieces(Mesh mesh, std::span<const float> support) {
    UnionFind pieces = find_vertex_pieces(mesh);
    std::vector<Index> count(mesh.positions.size()), supported(mesh.positions.size());
    for (Index v = 0; v < mesh.positions.size(); ++v) {
        ++count[pieces.find(v)];
        supported[pieces.find(v)] += support[v] > 0.0F;
    }
    const auto is_good = [&](const Triangle& t) {
        const Index piece = pieces.find(t[0]);
        return supported[piece] >= kLeastSupport * count[piece];
    };
    if (std::ranges::any_of(mesh.triangles, is_good))
        std::erase_if(mesh.triangles, [&](const Triangle& t) { return !is_good(t); });
    if (volume(mesh.positions, mesh.triangles) < 0.0)
        for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
    return compact(mesh);
}

}  // namespace pointbake
