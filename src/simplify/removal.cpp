#include "simplify/removal.h"

#include <algorithm>

#include "core/union_find.h"

namespace pointbake {
namespace {

struct Part {
    double area = 0.0;
    Index num_triangles = 0;
    Index root = kInvalidIndex;  // lowest vertex
};

// Lowest vertex of each vertex' part.
std::vector<Index> find_parts(const Surface& surface) {
    UnionFind sets(surface.positions.size());
    for (Index t = 0; t < surface.triangles.size(); ++t) {
        if (surface.is_removed(t)) continue;
        const Triangle& v = surface.triangles[t];
        sets.unite(v[0], v[1]);
        sets.unite(v[0], v[2]);
    }
    std::vector<Index> roots(sets.size());
    for (Index v = 0; v < roots.size(); ++v) roots[v] = sets.find(v);
    return roots;
}

}  // namespace

std::size_t drop_smallest_parts(Surface& surface, Attribution& attribution, Index num_triangles) {
    const std::vector<Index> roots = find_parts(surface);
    std::vector<Part> by_root(roots.size());
    for (Index t = 0; t < surface.triangles.size(); ++t) {
        if (surface.is_removed(t)) continue;
        Part& part = by_root[roots[surface.triangles[t][0]]];
        part.root = roots[surface.triangles[t][0]];
        part.area += triangle_area(surface, t);
        ++part.num_triangles;
    }
    std::erase_if(by_root, [](const Part& p) { return p.root == kInvalidIndex; });
    std::sort(by_root.begin(), by_root.end(), [](const Part& x, const Part& y) {
        return x.area != y.area ? x.area < y.area : x.root < y.root;
    });
    std::vector<bool> is_dropped(roots.size(), false);
    std::size_t num_dropped = 0;
    Index left = surface.num_triangles;
    for (; left > num_triangles && num_dropped + 1 < by_root.size(); ++num_dropped) {
        is_dropped[by_root[num_dropped].root] = true;
        left -= by_root[num_dropped].num_triangles;
    }
    for (Index t = 0; t < surface.triangles.size(); ++t) {
        if (surface.is_removed(t) || !is_dropped[roots[surface.triangles[t][0]]]) continue;
        surface.remove(t);
        attribution.first_points[t] = kInvalidIndex;
    }
    return num_dropped;
}

void drop_flat_triangles(Surface& surface, Attribution& attribution) {
    for (Index t = 0; t < surface.triangles.size(); ++t) {
        if (surface.is_removed(t) || triangle_area(surface, t) > 0.0) continue;
        Index heir = kInvalidIndex;
        for (Index v : surface.triangles[t]) {
            surface.for_each_corner(v, [&](Index c) {
                if (heir == kInvalidIndex && triangle_area(surface, c / 3) > 0.0) heir = c / 3;
            });
        }
        for (Index p = attribution.first_points[t]; p != kInvalidIndex && heir != kInvalidIndex;) {
            const Index next = attribution.next_points[p];
            attribution.add(heir, p);
            p = next;
        }
        attribution.first_points[t] = kInvalidIndex;
        surface.remove(t);
    }
}

}  // namespace pointbake
