// The mesh while it shrinks: triangles, and for each vertex the chain of its corners. Makes no
// assumption about manifoldness.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "pointbake/context.h"
#include "pointbake/types.h"

namespace pointbake {

/// What the surface is around a vertex. An edge is regular if exactly two triangles share it in
/// opposite directions; else (boundary, three or more sheets, clashing orientation) it is special.
enum class VertexKind : std::uint8_t {
    kInterior,  ///< one closed fan, regular edges only
    kCurve,     ///< on a curve of special edges: two of them, alike
    kFixed,     ///< anything else: never moved, never removed
};

struct Surface {
    std::vector<Vec3d> positions;
    std::vector<Triangle> triangles;  ///< removed: first entry kInvalidIndex
    std::vector<VertexKind> kinds;
    std::vector<Index> first_corners;  ///< per vertex, kInvalidIndex = no triangle
    std::vector<Index> next_corners;   ///< per corner 3 t + k, ends with kInvalidIndex
    Index num_triangles = 0;           ///< not removed

    /// Takes positions and triangles; skips triangles that name a vertex twice.
    Surface(std::vector<Vec3d> vertex_positions, const std::vector<Triangle>& all,
            const Context& context);

    bool is_removed(Index t) const { return triangles[t][0] == kInvalidIndex; }
    std::array<Vec3d, 3> corners_of(Index t) const {
        const Triangle& v = triangles[t];
        return {positions[v[0]], positions[v[1]], positions[v[2]]};
    }
    template <class Body>
    void for_each_corner(Index vertex, Body&& body) const {
        for (Index c = first_corners[vertex]; c != kInvalidIndex; c = next_corners[c]) body(c);
    }
    Index after(Index corner) const { return triangles[corner / 3][next_of(corner)]; }
    Index before(Index corner) const { return triangles[corner / 3][previous_of(corner)]; }

    /// Vertex b becomes a, which moves to `target`; triangles on both vanish (the caller counts
    /// them).
    void collapse(Index a, Index b, Vec3d target);
    void remove(Index triangle);

 private:
    static std::size_t next_of(Index corner) { return corner % 3 == 2 ? 0 : corner % 3 + 1; }
    static std::size_t previous_of(Index corner) { return corner % 3 == 0 ? 2 : corner % 3 - 1; }
    void unlink(Index corner, Index vertex);
};

/// Edges around a vertex with the numbers of triangles that run along them in either direction.
struct EdgeUse {
    Index neighbor;
    std::uint8_t num_out = 0, num_in = 0;
    bool is_special() const { return num_out != 1 || num_in != 1; }
    int num_triangles() const { return num_out + num_in; }
};

double triangle_area(const Surface& surface, Index triangle);

/// Edge uses of one vertex, in the order of its chain.
void collect_edges(const Surface& surface, Index vertex, std::vector<EdgeUse>& out);

}  // namespace pointbake
