// Object-space normals of a patch to the tangent-space map that glTF knows.
#pragma once

#include "pointbake/patch.h"
#include "texture/patch_texels.h"

namespace pointbake {

struct TangentFrame {
    Vec3f tangent;         ///< direction of +u in space
    std::int8_t sign = 1;  ///< bitangent = sign * cross(normal, tangent) points to the image's top
};

/// Recodes the texels of a normal patch for the pose it gets: the exact inverse of what a renderer
/// does with the interpolated, unnormalised normal, the tangent and their cross product (x to the
/// right, y to the top of the image).
TangentFrame to_tangent_space(PatchTexels& patch, const Shell& shell, const Mesh& mesh,
                              Index triangle, const Placement& placement);

}  // namespace pointbake
