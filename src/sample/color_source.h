// Colours of a textured mesh.
#pragma once

#include <span>
#include <vector>

#include "pointbake/context.h"
#include "sample/surface_sample.h"

namespace pointbake {

/// Rows from top to bottom; a channel holds 65535 sqrt(linear light): as fine in the dark as sRGB.
struct MipLevel {
    int width = 0, height = 0;
    std::vector<std::array<std::uint16_t, 3>> texels;
};

/// Box-filtered halvings of an image, the image itself first, down to one texel. Odd sides are
/// filtered with the exact shares of their texels.
std::vector<MipLevel> make_mips(const Image& image, const Context& context);

/// What a mesh has of colours: texture, else vertex colours, else the material's base colour.
class ColorSource {
 public:
    ColorSource(const TexturedMesh& model, const Context& context);

    bool has_colors() const;
    /// The colour around a place, averaged over about `spacing`: bilinear from the mip level whose
    /// texels are at most that large on this triangle. Textures repeat.
    Rgb16 color(const SurfaceSample& sample, double spacing) const;

 private:
    using Linear = std::array<double, 3>;
    const Material* material_of(Index triangle) const;
    Linear texture_color(std::span<const MipLevel> mips, const SurfaceSample& sample,
                         double spacing) const;
    Linear vertex_color(const SurfaceSample& sample) const;

    const TexturedMesh& model_;
    std::vector<std::vector<MipLevel>> mips_;  ///< per image; empty where no material uses it
};

}  // namespace pointbake
