// What packed and given layouts share on the way from texels to pages.
#pragma once

#include <span>
#include <vector>

#include "texture/normal_map.h"
#include "texture/triangle_gauge.h"

namespace pointbake {

/// What is painted: the splats with their own values and with those that sharpening made of them.
struct PaintSource {
    const SplatScene& scene;
    const PointCloud& cloud;
    MapKind kind;
    std::span<const Vec3f> raw, sharpened;  ///< per item of the footprints
};

/// Pages of zeros that no patch owns yet, with a material each.
BakedTexture empty_pages(const PaintSource& source, std::span<const PageSize> pages);

/// The written texture against the points' own colours.
class RawErrors {
 public:
    explicit RawErrors(const PaintSource& source)
        : source_(source), errors_(source.raw.size(), 0.0F) {}
    /// At the points of one triangle; different triangles may be measured at once.
    void measure(Index triangle, const PatchTexels& patch);
    void summarise(BakedTexture& out);

 private:
    PaintSource source_;
    std::vector<float> errors_;
};

/// Recodes a normal patch for the pose it gets and notes its tangent; nothing for colours.
void settle_tangent(const PaintSource& source, Index triangle, const Placement& placement,
                    PatchTexels& patch, TexturedMesh& model);

}  // namespace pointbake
