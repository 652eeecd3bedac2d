// Whether an edge may be collapsed: topology, shape, orientation and the attribution test.
#pragma once

#include <vector>

#include "pointbake/types.h"
#include "simplify/attribution.h"
#include "simplify/border_trace.h"
#include "simplify/face_frame.h"
#include "simplify/surface.h"

namespace pointbake {

/// What may be given up to reach a number of triangles, one after the other.
enum class Strictness { kFull, kShapeFree, kTopologyOnly };

enum class Verdict { kLegal, kTopology, kShape, kBound };

/// Judges one collapse after the other, and carries it out. Collapses whose closed rings share no
/// vertex may be judged and applied by several judges at once: give each its own, all with the same
/// `marks` (one byte per vertex, zero).
class CollapseJudge {
 public:
    CollapseJudge(Surface& surface, Attribution& attribution, BorderTrace& trace,
                  std::vector<std::uint8_t>& marks, double squared_limit)
        : surface_(surface),
          attribution_(attribution),
          border_(trace),
          marks_(marks),
          limit_(squared_limit) {}

    Strictness strictness = Strictness::kFull;

    /// Vertices a and b become one at `target`.
    Verdict judge(Index a, Index b, Vec3d target);
    /// Carries out the collapse that was judged last; b vanishes. Returns the triangles removed.
    Index apply(Index a, Index b, Vec3d target);

 private:
    struct Move {
        Index point;
        std::uint32_t face;  // index into new_faces_
    };

    bool is_topology_kept(Index a, Index b);
    bool covers_triangle(Index a, Index b);
    bool make_new_faces(Index a, Index b, Vec3d target);
    bool is_border_kept(Index a, Index b, Vec3d target);
    bool replace_corner(Index corner, Vec3d target);
    Verdict reattribute();
    Verdict reattribute(Index old_face);
    std::uint32_t nearest_facing(Vec3d x, Vec3d n, double least_cosine) const;

    Surface& surface_;
    Attribution& attribution_;
    BorderJudge border_;
    BorderEnds border_ends_;
    std::vector<std::uint8_t>& marks_;
    double limit_;
    std::vector<EdgeUse> edges_a_, edges_b_;
    std::vector<Index> removed_faces_, kept_faces_;
    std::vector<FaceFrame> new_faces_;  // of kept_faces_
    std::vector<Move> moves_;
    double worst_before_ = 1.0, worst_after_ = 1.0;
};

}  // namespace pointbake
