// Meshes as files want them: one part per material, vertices split where texture coordinates
// differ.
#pragma once

#include <span>
#include <vector>

#include "pointbake/context.h"
#include "pointbake/types.h"
#include "write/tangents.h"

namespace pointbake {

/// The triangles of one material.
struct MeshPart {
    Index material = 0;
    std::vector<Index> corners;  ///< per vertex of the part: 3 * triangle + corner it stands for
    std::vector<Index> indices;  ///< three per triangle, into corners
};

struct SplitOptions {
    bool by_uv = false;  ///< corners with different texture coordinates are different vertices
    const Tangents* tangents = nullptr;  ///< corners of triangles with different tangents, too
};

/// Throws Error{kInvalidInput} if arrays do not fit each other, an index is out of range, or a
/// coordinate is not finite.
void check_model(const TexturedMesh& model);

/// The material of a triangle.
inline Index material_of(const TexturedMesh& model, std::size_t triangle) {
    return model.triangle_materials.empty() ? 0 : model.triangle_materials[triangle];
}

/// Parts in the order of materials, none empty; vertices in the order of their first use, so the
/// result depends on the model alone. Expected O(n). `triangles` are those of the model, possibly
/// with other vertices; those with a repeated vertex are left out. `options` has one entry per
/// material.
std::vector<MeshPart> split_by_material(const TexturedMesh& model,
                                        std::span<const Triangle> triangles,
                                        std::span<const SplitOptions> options,
                                        const Context& context = {});

/// The model's triangles with vertices that fell on each other by rounding made one, where a
/// triangle's edge joins them: such an edge is contracted, which keeps a closed surface closed.
std::vector<Triangle> contract_equal(std::span<const Triangle> triangles,
                                     std::span<const Vec3f> positions);

}  // namespace pointbake
