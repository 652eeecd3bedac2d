// The faces of a PLY file as triangles.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "io/ply_body.h"
#include "pointbake/types.h"

namespace pointbake {

struct PlyFaces {
    std::vector<Triangle> triangles;        ///< over points, not rows
    std::vector<std::array<Vec2f, 3>> uvs;  ///< as in the file (origin at the lower left)
    std::vector<Index> textures;            ///< the file's texture number of each triangle
    std::uint64_t num_bad = 0;              ///< faces dropped
};

/// The element that holds faces: "face" with a list vertex_indices or vertex_index, else
/// "tristrips".
std::optional<std::size_t> find_faces(const PlyHeader& header);

/// Polygons are split into fans, strips (-1 begins a new one) into triangles of alternating order.
/// Corners go through point_of_row. A face with a bad corner, or fewer than three different ones,
/// is dropped. Texture coordinates and numbers are read if `with_texture` is set and they are
/// there.
PlyFaces read_ply_faces(const PlyBody& body, const PlyHeader& header, std::size_t element,
                        std::span<const Index> point_of_row, bool with_texture,
                        const Context& context);

}  // namespace pointbake
