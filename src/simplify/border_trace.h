// Where the borders of the dense surface were: points alone do not hold a border, as a triangle
// that covers a hole is far from none of them.
#pragma once

#include <span>
#include <vector>

#include "pointbake/types.h"
#include "simplify/surface.h"

namespace pointbake {

/// Each vertex of a dense border is in the chain of the light border edge that stands for it. An
/// edge is known by the vertex it leaves, in the direction of its triangle.
struct BorderTrace {
    struct Place {
        Vec3d here, next;  ///< the dense border runs straight from here to next
        Index link = kInvalidIndex;
    };
    std::vector<Place> places;
    std::vector<Index> first_places;  ///< per vertex

    explicit BorderTrace(const Surface& surface);

    template <class Body>
    void for_each_place(Index vertex, Body&& body) const {
        for (Index p = first_places[vertex]; p != kInvalidIndex; p = places[p].link) body(p);
    }
    void add(Index vertex, Index place) {
        places[place].link = first_places[vertex];
        first_places[vertex] = place;
    }
};

/// The border edges into and out of an edge that becomes one vertex; kInvalidIndex where there is
/// none.
struct BorderEnds {
    Index before = kInvalidIndex, after = kInvalidIndex;
    bool is_none() const { return before == kInvalidIndex && after == kInvalidIndex; }
};
BorderEnds find_border_ends(Index a, std::span<const EdgeUse> edges_a, Index b,
                            std::span<const EdgeUse> edges_b);

/// Judges the border that a collapse leaves, and carries it out.
class BorderJudge {
 public:
    explicit BorderJudge(BorderTrace& trace) : trace_(trace) {}

    /// Whether the dense border stays within the limit of the light one, and `target` of the dense
    /// one, if vertices a and b become one there.
    bool is_within(const Surface& surface, Index a, Index b, BorderEnds ends, Vec3d target,
                   double squared_limit);
    /// Carries out what was judged last.
    void apply(Index a, Index b, BorderEnds ends);

 private:
    struct Move {
        Index place;
        bool is_before;  // belongs to the edge that enters the new vertex
    };
    BorderTrace& trace_;
    std::vector<Move> moves_;
};

}  // namespace pointbake
