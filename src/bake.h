// Texture and atlas together: sizes are chosen so that the packed pages keep the budget.
#pragma once

#include <span>

#include "pointbake/convert.h"

namespace pointbake {

struct BakeResult {
    TexturedMesh model;
    TextureReport texture;
    AtlasReport atlas;
};

/// `owners`: per point the triangle it belongs to. Never over the budget; the pages are at least
/// 0.9 of it unless every patch is at its cap.
BakeResult bake_texture(const Mesh& mesh, const PointCloud& cloud, std::span<const Index> owners,
                        const ConvertOptions& options, const Context& context);

/// --keep-uvs: into the texture coordinates that the mesh has, on pages that its materials name.
BakeResult bake_into_layout(const Mesh& mesh, const GivenLayout& layout, const PointCloud& cloud,
                            std::span<const Index> owners, const ConvertOptions& options,
                            const Context& context);

}  // namespace pointbake
