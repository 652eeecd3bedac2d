// From a layout of triangles on pages to the pages: who owns each texel, what it shows, and how far
// that is from the splats.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "texture/level_errors.h"
#include "texture/paint_pages.h"
#include "texture/texel_fit.h"

namespace pointbake {

/// Where all triangles lie. Layouts are among the texels of their pages.
struct PageLayout {
    std::vector<PageSize> pages;
    std::vector<std::uint8_t> repeats;  ///< per page: it begins again beyond its border
    bool has_mips = false;              ///< of charts: viewers may use mip levels
    std::vector<Index> triangle_pages;
    std::vector<PatchLayout> triangles;
    std::vector<double> gutters;  ///< per triangle: texels beyond the border that it paints
};

/// What is wrong at the points of one triangle.
struct PointError {
    std::size_t num_points = 0;
    double area = 0.0;  ///< that they stand for
    float rms = 0.0F;   ///< 8-bit steps
};

class PagePainter {
 public:
    /// All must outlive it.
    PagePainter(const PaintSource& source, const PageLayout& layout, const Context& context);

    /// A texel belongs to the first triangle that covers its centre; else, within a gutter, to the
    /// nearest; else to the first that needs it.
    void find_owners();
    /// Every triangle splats the texels that belong to it; `for_fit`: and what fit() goes by.
    void paint(bool for_fit = false);
    /// Makes texels that are coarser than the points fit them, and both sides of every border show
    /// the same. Colours only, after paint(true).
    void fit();
    /// Lets each page be filled and coded; what it holds then is what is measured.
    void finish(const std::function<void(Image&, std::span<const std::uint8_t>)>& finish_page);
    /// Pictures of the pages; after measure().
    void draw_debug_maps();
    /// Errors on the pages. `cap` tells why a triangle is above the bound, with a gauge to look at
    /// it.
    void measure(double bound, const std::function<CapCount(Index, TriangleGauge&)>& cap);

    bool is_paintable(Index triangle) const { return is_paintable_[triangle] != 0; }
    std::uint64_t num_shared() const;  ///< texels inside several triangles
    BakedTexture take() { return std::move(out_); }

 private:
    struct TexelOwner {
        Index triangle = kInvalidIndex;
        // As the triangle's corners have it: pages may repeat.
        std::int32_t x = 0, y = 0;
        float distance = 0.0F;  // to the triangle; infinite where it merely needs the texel
        bool is_inside = false, is_shared = false;
    };
    struct Owned {
        NeedSet need;
        double beyond = 0.0;  // texels that the farthest lies outside the triangle
    };
    struct Sample {
        TexelFit::Tap tap;
        Vec3f wanted;
    };
    double gutter(Index triangle) const {
        return layout_.gutters.empty() ? 0.0 : layout_.gutters[triangle];
    }
    void claim_inside(Index triangle);
    void claim_gutter(Index triangle);
    bool is_border(Index triangle, std::size_t k) const;
    Vec2d corner_at(Index triangle, Index vertex) const;
    Owned owned_by(Index triangle) const;
    std::uint64_t copy(Index triangle, const PatchTexels& texels);
    std::uint64_t paint_triangle(Index triangle, const TriangleGauge& gauge, NeedSet owned);
    std::vector<Sample> samples_of(Index triangle, const TriangleGauge& gauge) const;
    void add_priors();
    void add_border(Index triangle, std::size_t k);
    Vec3f read_page(std::span<const Image> pages, Index triangle, Vec2f place) const;
    bool is_lost_by_format(Index triangle, double bound, TriangleGauge& gauge) const;
    std::vector<TextureReport::Density> densities(std::span<const double> areas) const;
    std::vector<float> pool_small(std::span<const PointError> at_points) const;
    bool has_texel(Index page, int x, int y) const;

    const PaintSource source_;
    const PageLayout& layout_;
    const Context& context_;
    std::vector<std::uint8_t> is_paintable_;  // per triangle
    std::vector<std::vector<TexelOwner>> owners_;
    std::vector<float> errors_;  // per triangle
    TexelFit::Values values_;    // of the texels, not rounded
    std::optional<TexelFit> fit_;
    std::vector<std::uint8_t> is_coarse_;  // per triangle: texels are coarser than its points
    std::vector<Image> exact_;  // pages before a format lost some of them; empty = none did
    BakedTexture out_;
};

}  // namespace pointbake
