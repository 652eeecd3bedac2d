// Textures in the layout that a mesh brings along: nothing is packed, only the size of the pages is
// chosen.
#pragma once

#include "pointbake/texture.h"
#include "texture/paint_pages.h"

namespace pointbake {

struct GivenLimits {
    double bound;  ///< RMS per triangle, 8-bit steps; infinite: as fine as the points allow
    std::int64_t max_texels;
    int page_size;
};

/// As TextureBaker::bake_given.
GivenBake paint_given(const PaintSource& source, const GivenLayout& layout,
                      const GivenLimits& limits, const Context& context);

}  // namespace pointbake
