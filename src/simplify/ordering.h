// What a collapse costs: quadrics and the place of the merged vertex.
#pragma once

#include <vector>

#include "pointbake/context.h"
#include "pointbake/types.h"
#include "simplify/quadric.h"
#include "simplify/surface.h"

namespace pointbake {

class CollapseOrder {
 public:
    CollapseOrder(const Surface& surface, const Context& context);

    /// Where the merged vertex goes: to the one that may not leave its place, else to the least
    /// error.
    Vec3d placement(Index a, Index b) const;
    float cost(Index a, Index b) const;
    bool is_movable(Index a, Index b) const {
        return surface_.kinds[a] != VertexKind::kFixed || surface_.kinds[b] != VertexKind::kFixed;
    }
    void merge(Index a, Index b) { quadrics_[a] += quadrics_[b]; }

 private:
    void add_boundary_planes(Index v, const std::vector<EdgeUse>& edges);
    Vec3d placement(Index a, Index b, const Quadric& q) const;

    const Surface& surface_;
    std::vector<Quadric> quadrics_;
};

}  // namespace pointbake
