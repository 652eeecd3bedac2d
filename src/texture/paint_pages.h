// What packed and given layouts share on the way from texels to pages.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "texture/normal_map.h"
#include "texture/triangle_gauge.h"

namespace pointbake {

struct PaintSource {
    const SplatScene& scene;
    const PointCloud& cloud;
    MapValues map;
    std::span<const Vec3f> raw;  ///< the points' own values, per item of the footprints
    bool is_paper = false;       ///< errors by [Wicke05] eq. (1)
};

/// Pages of zeros that no patch owns yet, with a material each.
BakedTexture empty_pages(const PaintSource& source, std::span<const PageSize> pages);

/// A texture against the colours of the points that are seen.
class RawErrors {
 public:
    explicit RawErrors(const PaintSource& source)
        : source_(source), errors_(source.raw.size(), 0.0F) {}
    /// At the points of one triangle, of what `read` finds at places in its plane; different
    /// triangles may be measured at once.
    void measure(Index triangle, const std::function<Vec3f(Vec2f)>& read);
    void measure(Index triangle, const PatchTexels& patch);
    void summarise(TextureReport& out) const;

 private:
    PaintSource source_;
    std::vector<float> errors_;
};

/// Recodes a normal patch for the pose it gets and notes its tangent; nothing for colours.
void settle_tangent(const PaintSource& source, Index triangle, const Placement& placement,
                    PatchTexels& patch, TexturedMesh& model);

}  // namespace pointbake
