// Object-space normals of a patch to the tangent-space map that glTF knows.
#pragma once

#include "pointbake/patch.h"
#include "texture/patch_texels.h"

namespace pointbake {

struct TangentFrame {
    Vec3f tangent;         ///< direction of +u in space
    std::int8_t sign = 1;  ///< bitangent = sign * cross(normal, tangent) points to the image's top
};

/// Of a patch that is laid out so and placed so.
TangentFrame tangent_frame(const TriangleFrame& frame, const PatchLayout& layout,
                           const Placement& placement);

/// Recodes the texels of a normal patch: the exact inverse of what a renderer does with the
/// interpolated, unnormalised normal, the tangent and their cross product (x to the right, y to the
/// top of the image).
void to_tangent_space(PatchTexels& patch, const Shell& shell, Index triangle,
                      const TangentFrame& tangent);

}  // namespace pointbake
