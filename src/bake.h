// Texture and atlas together: sizes are chosen so that the packed pages keep the budget, or, for a
// layout that is given, so that its pages do.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "pointbake/convert.h"

namespace pointbake {

struct BakeResult {
    TexturedMesh model;
    std::vector<DebugMap> debug_maps;
    TextureReport texture;
    AtlasReport atlas;
    std::vector<std::string> warnings;
};

/// The layout of a mesh with a page for each material in use, shaped like its image. Throws
/// Error{kInvalidOption} if there is none, Error{kInvalidInput} for a mesh without texture
/// coordinates or whose parts do not fit together.
GivenLayout given_layout(const std::optional<TexturedMesh>& mesh);

/// `owners`: per point the triangle it belongs to; `layout`: with --keep-uvs. Never over the
/// budget; the pages are at least 0.9 of it unless every patch is at its cap.
BakeResult bake_texture(const Mesh& mesh, const PointCloud& cloud, std::span<const Index> owners,
                        const std::optional<GivenLayout>& layout, const ConvertOptions& options,
                        const Context& context);

}  // namespace pointbake
