// What a lit surface needs beside its positions.
#pragma once

#include <span>
#include <vector>

#include "pointbake/types.h"

namespace pointbake {

/// Unit normals per vertex: the mesh's own where they are there and not zero, else the
/// area-weighted mean of the triangles around.
std::vector<Vec3f> unit_normals(const Mesh& mesh);

/// Per triangle: the direction of +u and the handedness.
struct Tangents {
    std::vector<Vec3f> directions;
    std::vector<std::int8_t> signs;
};

/// The model's own tangents, or else [Lengyel01] from the texture coordinates. The sign is that of
/// glTF, whose v runs down while a normal map's y runs up.
Tangents triangle_tangents(const TexturedMesh& model);

/// Unit vector along a tangent; one perpendicular to the normal if it is zero or not finite.
Vec3f unit_tangent(Vec3f tangent, Vec3f normal);

}  // namespace pointbake
