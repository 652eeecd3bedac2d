// Stage 5: each triangle gets a patch of texels, splatted from the points, as large as its detail
// needs.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "pointbake/context.h"
#include "pointbake/options.h"
#include "pointbake/patch.h"
#include "pointbake/simplify.h"
#include "pointbake/types.h"

namespace pointbake {

enum class AtlasKind { kCharts, kTriangles };
template <>
struct EnumWords<AtlasKind> {
    static constexpr std::string_view words[] = {"charts", "triangles"};
};

enum class Projection { kInterpolated, kOrthographic };
template <>
struct EnumWords<Projection> {
    static constexpr std::string_view words[] = {"interpolated", "orthographic"};
};

struct TextureOptions {
    std::optional<double> texture_error;  ///< unset: 4, or no bound if a number of texels is given
    std::optional<std::uint64_t> texels;  ///< unset: no budget; 0: no texture, colours of vertices
    AtlasKind atlas = AtlasKind::kCharts;
    int mips = 2;
    Projection projection = Projection::kInterpolated;
    int max_patch = 1024;
    int max_side = 4096;  ///< of a chart: what a page has room for
    bool paper = false;
    bool keep_uvs = false;
    std::optional<HexColor> debug_background;
    bool debug_maps = false;  ///< BakedTexture::debug_maps are made
    /// Called with each page that is painted, before it is measured, and its owned texels: fills
    /// it, codes it.
    std::function<void(Image&, std::span<const std::uint8_t>)> finish_page{};
    template <class Field>
    static void describe(Field&& field) {
        field("texture-error", &TextureOptions::texture_error,
              "largest RMS difference between texture and splats per triangle, in 8-bit sRGB steps "
              "(default 4)");
        field("texels", &TextureOptions::texels,
              "at most this many texels over all pages of a map; alone, it replaces the default "
              "bound; 0 = no texture: vertices get colours");
        field("atlas", &TextureOptions::atlas,
              "a patch is a chart of many triangles, or one triangle");
        field("mips", &TextureOptions::mips,
              "2^N texels around each chart are its own: mip levels below N stay clean");
        field("projection", &TextureOptions::projection,
              "points are projected along the interpolated vertex normal, or the triangle's "
              "(orthographic)");
        field("max-patch", &TextureOptions::max_patch,
              "longest side of a triangle's patch in texels");
        field("keep-uvs", &TextureOptions::keep_uvs,
              "bake into the texture coordinates of the given mesh, which stays as it is");
        field("paper", &TextureOptions::paper, "all choices of Wicke, Olibet, Gross 2005");
        field("debug-background", &TextureOptions::debug_background,
              "texels that no patch needs get this colour instead of one that suits mip levels");
    }
};

/// Why a triangle stopped before its error reached the bound.
struct CappedCounts {
    Index by_spacing = 0;  ///< texels are finer than the points: more tell nothing new
    Index by_count = 0;    ///< 8 texels per point
    Index by_size = 0;     ///< longest side of a patch or page
    Index by_budget = 0;   ///< --texels
    Index by_layout = 0;   ///< shares its texels with others, or has none
    Index by_format = 0;   ///< what the image format loses
    Index total() const {
        return by_spacing + by_count + by_size + by_budget + by_layout + by_format;
    }
};

struct TextureReport {
    double bound = 0.0;     ///< 8-bit sRGB steps; infinite if only a budget was given
    bool bound_met = true;  ///< no triangle capped
    CappedCounts capped;
    double error_mean = 0.0, error_rms = 0.0, error_p99 = 0.0,
           error_max = 0.0;  ///< per-triangle RMS to the splats
    double raw_rms = 0.0,
           raw_p99 = 0.0;       ///< texture against the points' own colours, over all points
    int sharpening_rounds = 0;  ///< chosen by leave-out prediction
    std::uint64_t num_hidden_points = 0;  ///< seen from behind, or under another layer
    std::uint64_t num_uncovered_texels =
        0;  ///< inside a triangle, but no splat reached them; filled from those around
    Index num_unseen_vertices = 0;  ///< --texels 0: coloured by their neighbours
    std::uint64_t num_patches = 0, num_needed_texels = 0;
    double payload_texels =
        0.0;  ///< surface area in texels: sum of the triangles' areas in the pages
    double largest_stretch =
        1.0;  ///< charts: of lengths on the surface to those in the page, either way
    /// How much of the surface has at least so many texels per unit, and less than twice as many;
    /// coarse to fine, powers of two.
    struct Density {
        double texels_per_unit = 0.0;
        double area_share = 0.0;
    };
    std::vector<Density> densities;
};

/// Sizes chosen for all patches: what the atlas packs.
struct TexturePlan {
    std::vector<std::uint8_t> levels;  ///< per patch: its size, small to large
    std::vector<PatchShape> shapes;    ///< per patch
    std::int64_t num_needed = 0;       ///< texels of all shapes
    bool all_at_cap = false;           ///< no patch could use more texels
    /// Per patch: levels beyond those that its triangles want by themselves; empty = none.
    std::vector<std::uint8_t> raised;
};

/// A picture of what a page's texels are, as large as the page.
struct DebugMap {
    std::string name;  ///< "coverage-0", "error-0", "density-0", ...
    Image image;
};

/// A model whose pages are filled where patches need them.
struct BakedTexture {
    TexturedMesh model;
    std::vector<std::vector<std::uint8_t>>
        owned;  ///< per page, one byte per texel: 1 = a patch needs it
    /// Per triangle: 1 = its error is above the bound because it shares texels with others.
    std::vector<std::uint8_t> is_missed;
    TextureReport report;
    /// If asked for. Coverage: white inside a triangle, grey in a gutter. Error: RMS of the
    /// triangle that owns the texel, 16 levels of grey per 8-bit step. Density: grey is the
    /// median, 32 levels lighter for each doubling.
    std::vector<DebugMap> debug_maps;
};

/// A layout that a mesh brings along: its texture coordinates, and a page for each of its
/// materials.
struct GivenLayout {
    struct Page {
        std::string name;
        PageSize proportions;  ///< of its sides; the size is chosen
    };
    std::vector<Page> pages;
    std::vector<Index> triangle_pages;  ///< per triangle
};

/// Throws Error{kInvalidInput} unless the mesh has texture coordinates of at most 16 and each
/// triangle a page.
void validate(const Mesh& mesh, const GivenLayout& layout);

struct GivenLimits {
    double bound = 0.0;  ///< RMS per triangle, 8-bit steps; infinite: as fine as the points allow
    std::vector<std::vector<PageSize>> sizes;  ///< of the pages to choose from, small to large
    bool ends_with_budget = false;             ///< the budget allows no larger ones
};

/// What comes of baking into a given layout.
struct GivenBake {
    BakedTexture texture;
    std::vector<PageSize> pages;
    std::uint64_t num_shared_texels = 0;  ///< texels inside several triangles (mirrored layouts)
    Index num_without_area = 0;           ///< triangles that cover no area of their page
};

/// Makes textures for one mesh and one cloud. Construction projects every point once (linear time);
/// planning measures the error of every patch at every size it may need; baking writes the chosen
/// sizes into pages. The mesh, the cloud and the owners must outlive it.
class TextureBaker {
 public:
    /// `owners`: per point the triangle it was attributed to, kInvalidIndex = none. The cloud needs
    /// areas and either colours or normals. Charts are cut by wanted density only if
    /// options.texture_error is set; it is then the bound of the plans to come.
    TextureBaker(const Mesh& mesh, const PointCloud& cloud, std::span<const Index> owners,
                 const TextureOptions& options, const Context& context);
    ~TextureBaker();

    /// Smallest sizes whose error is at most `bound` (8-bit sRGB steps), as far as caps allow,
    /// together needing at most `max_needed` texels: where that is too few they are spent where
    /// they lower the squared error most.
    TexturePlan plan(double bound, std::int64_t max_needed, const Context& context = {}) const;

    /// A plan with a bound alone, once more, after its pages were measured: larger patches where
    /// more than a few triangles missed the bound because they share texels with others. Nothing
    /// if no patch is to become larger.
    std::optional<TexturePlan> refined(const TexturePlan& plan, double bound,
                                       const BakedTexture& baked,
                                       const Context& context = {}) const;

    /// Splats the plan's patches into pages and fills in texture coordinates and materials. Errors
    /// are measured on the written pages.
    BakedTexture bake(const TexturePlan& plan, double bound, std::span<const PageSize> pages,
                      std::span<const Placement> placements, const Context& context) const;

    /// Splats into the mesh's own texture coordinates instead (with options.keep_uvs, which leaves
    /// out the planning), on the first pages where every triangle's error is at most the bound or
    /// its texels are as fine as its points allow. Texels that several triangles share belong to
    /// the first; pages repeat where texture coordinates leave 0..1. Errors are measured on the
    /// written pages. Throws Error{kInvalidInput} as validate() does and if no triangle covers any
    /// area, Error{kLimit} if one covers too many texels even on the smallest pages.
    GivenBake bake_given(const GivenLayout& layout, const GivenLimits& limits,
                         const Context& context) const;

 private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// Colours of a mesh's vertices, instead of a texture.
struct VertexColors {
    std::vector<Rgb16> colors;    ///< per vertex
    double rms = 0.0, p99 = 0.0;  ///< between the triangles, shaded linearly in linear light, and
                                  ///< the points' own colours: 8-bit sRGB steps
    Index num_unseen = 0;  ///< vertices without points around them: coloured by their neighbours
};

/// The mean, in linear light, of the points on the triangles around each vertex, weighted by the
/// areas that they stand for and by how near they are to the vertex (1 there, 0 on the opposite
/// edge). Linear time. The cloud needs areas and colours; `owners` as for TextureBaker. Vertices
/// without triangles are black.
VertexColors color_vertices(const Mesh& mesh, const PointCloud& cloud,
                            std::span<const Index> owners, const TextureOptions& options,
                            const Context& context = {});

}  // namespace pointbake
