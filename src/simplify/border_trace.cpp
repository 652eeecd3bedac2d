#include "simplify/border_trace.h"

#include <algorithm>
#include <cmath>

#include "core/segment.h"

namespace pointbake {
BorderTrace::BorderTrace(const Surface& surface)
    : first_places(surface.positions.size(), kInvalidIndex) {
    std::vector<EdgeUse> edges;
    for (Index v = 0; v < first_places.size(); ++v) {
        if (surface.kinds[v] == VertexKind::kInterior) continue;
        collect_edges(surface, v, edges);
        for (const EdgeUse& e : edges) {
            if (e.num_out != 1 || e.num_in != 0) continue;
            places.push_back({surface.positions[v], surface.positions[e.neighbor]});
            add(v, static_cast<Index>(places.size() - 1));
        }
    }
}

BorderEnds find_border_ends(Index a, std::span<const EdgeUse> edges_a, Index b,
                            std::span<const EdgeUse> edges_b) {
    BorderEnds ends;
    const auto look = [&](std::span<const EdgeUse> edges, Index other) {
        for (const EdgeUse& e : edges) {
            if (e.num_triangles() != 1 || e.neighbor == other) continue;
            (e.num_out == 1 ? ends.after : ends.before) = e.neighbor;
        }
    };
    look(edges_a, b);
    look(edges_b, a);
    return ends;
}

bool BorderJudge::is_within(const Surface& surface, Index a, Index b, BorderEnds ends, Vec3d target,
                            double squared_limit) {
    moves_.clear();
    double off = HUGE_VAL;  // the target from the dense border
    bool is_fine = true;
    const auto distance_to = [&](Vec3d p, Index end) {
        return end == kInvalidIndex
                   ? HUGE_VAL
                   : squared_distance_to_segment(p, surface.positions[end], target);
    };
    const auto judge = [&](Index p) {
        const auto& [here, next, link] = trace_.places[p];
        const double before = distance_to(here, ends.before), after = distance_to(here, ends.after);
        is_fine = is_fine && std::min(before, after) <= squared_limit;
        off = std::min(off, squared_distance_to_segment(target, here, next));
        moves_.push_back({p, before <= after});
    };
    if (ends.before != kInvalidIndex) trace_.for_each_place(ends.before, judge);
    trace_.for_each_place(a, judge);
    trace_.for_each_place(b, judge);
    return is_fine && (moves_.empty() || off <= squared_limit);
}

void BorderJudge::apply(Index a, Index b, BorderEnds ends) {
    for (const Index v : {ends.before, a, b})
        if (v != kInvalidIndex) trace_.first_places[v] = kInvalidIndex;
    for (const Move& m : moves_) trace_.add(m.is_before ? ends.before : a, m.place);
}

}  // namespace pointbake
