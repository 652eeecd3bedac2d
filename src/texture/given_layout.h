// Textures in the layout that a mesh brings along: nothing is packed, only the size of the pages is
// chosen.
#pragma once

#include "pointbake/texture.h"
#include "texture/paint_pages.h"

namespace pointbake {

/// As TextureBaker::bake_given.
GivenBake paint_given(const PaintSource& source, const GivenLayout& layout,
                      const GivenLimits& limits, const TextureOptions& options,
                      const Context& context);

}  // namespace pointbake
