#include "bake.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/message.h"
#include "core/parallel.h"
#include "io/image_io.h"
#include "write/encode_image.h"

namespace pointbake {
namespace {

constexpr double kDefaultTextureError = 4.0;  // 8-bit sRGB steps
// Packings tried to fill the budget's pages: the first asks for this share of them, the next for
// more or less by a step, and those after for what is between.
constexpr int kFitSteps = 7;
constexpr double kFirstFillOfTriangles = 0.93, kFirstFillOfCharts = 0.8, kFillStep = 1.06;
constexpr double kFillPrecision = 0.006;

struct Fitted {
    TexturePlan plan;
    std::vector<PageSize> pages;
    std::vector<Placement> placements;
};

// Texels over all pages; 0 = no budget.
std::int64_t budget_of(const TextureOptions& options) {
    return static_cast<std::int64_t>(options.texels.value_or(0));
}

// No patch may be larger than the pages that the budget buys.
int smallest_page_side(const ConvertOptions& options) {
    int side = options.atlas.page_size;
    const std::int64_t budget = budget_of(options.texture);
    if (budget == 0) return side;
    for (const PageSize& page : budget_pages(budget, options.atlas))
        side = std::min({side, page.width, page.height});
    return side;
}

// The largest plan that fits the pages which the budget buys.
Fitted fit_budget(const TextureBaker& baker, double bound, const ConvertOptions& options,
                  const Context& context) {
    const std::int64_t budget = budget_of(options.texture);
    const std::vector<PageSize> pages = budget_pages(budget, options.atlas);
    const std::int64_t area = num_texels(pages);

    // If all patches are as large as they may be, the pages shrink to what they need.
    TexturePlan whole = baker.plan(bound, area, context);
    if (whole.all_at_cap) {
        Packing packing = pack(whole.shapes, options.atlas, context);
        if (packing.num_texels <= budget)
            return {std::move(whole), packing.pages, packing.placements};
    }
    std::optional<Fitted> best;
    const bool has_charts = options.texture.atlas == AtlasKind::kCharts;
    double low = 0.0, high = static_cast<double>(std::min(area, whole.num_needed));
    double next = (has_charts ? kFirstFillOfCharts : kFirstFillOfTriangles) * high;
    for (int step = 0; step < kFitSteps || !best; ++step) {
        check_cancelled(context);
        TexturePlan plan = baker.plan(bound, static_cast<std::int64_t>(next), context);
        log(context, LogLevel::kDebug, "texture: packing {} patches that need {} of {} texels",
            plan.shapes.size(), plan.num_needed, area);
        std::optional<Packing> packing = pack_into(plan.shapes, pages, options.atlas, context);
        if (packing) {
            low = next;
            best = Fitted{std::move(plan), pages, std::move(packing->placements)};
        } else {
            if (plan.num_needed > static_cast<std::int64_t>(next) && !best) {
                fail(ErrorCode::kLimit,
                     "--texels {}: the smallest patches of {} triangles do not fit", budget,
                     plan.levels.size());
            }
            high = next;
        }
        if (high - low < kFillPrecision * high) break;
        next = best ? std::min(0.5 * (low + high), low * kFillStep) : high / kFillStep;
    }
    return std::move(*best);
}

Fitted packed(TexturePlan plan, const ConvertOptions& options, const Context& context) {
    Packing packing = pack(plan.shapes, options.atlas, context);
    return {std::move(plan), std::move(packing.pages), std::move(packing.placements)};
}

Fitted fit(const TextureBaker& baker, double bound, const ConvertOptions& options,
           const Context& context) {
    if (budget_of(options.texture) > 0) return fit_budget(baker, bound, options, context);
    return packed(baker.plan(bound, std::numeric_limits<std::int64_t>::max(), context), options,
                  context);
}

// What was measured on the pages may be more than each triangle by itself promised: once more,
// then, with larger patches where it is. (A second time makes few more triangles hold their bound.)
void refine_in_place(BakedTexture& baked, Fitted& fitted, const TextureBaker& baker, double bound,
                     const ConvertOptions& options, const Context& context) {
    if (!std::isfinite(bound) || budget_of(options.texture) > 0 || options.texture.paper) return;
    std::optional<TexturePlan> plan = baker.refined(fitted.plan, bound, baked, context);
    if (!plan) return;
    Fitted larger = packed(std::move(*plan), options, context);
    BakedTexture again = baker.bake(larger.plan, bound, larger.pages, larger.placements, context);
    if (again.report.capped.total() >= baked.report.capped.total()) return;
    fitted = std::move(larger);
    baked = std::move(again);
}

void paint_unowned(Image& page, std::span<const std::uint8_t> owned, HexColor color) {
    for (std::size_t i = 0; i < owned.size(); ++i)
        if (owned[i] == 0)
            page.pixels[3 * i] = color.r, page.pixels[3 * i + 1] = color.g,
                            page.pixels[3 * i + 2] = color.b;
}

// A page as it is written: filled where no patch needs it, and coded. Only colours are coded with
// loss.
void finish_page(Image& page, std::span<const std::uint8_t> owned, const ConvertOptions& options,
                 bool is_color, const Context& context) {
    if (options.texture.debug_background)
        paint_unowned(page, owned, *options.texture.debug_background);
    else
        fill_unowned_in_place(page, owned, context);
    if (!is_color || options.images.format == ImageFormat::kPng) return;
    page.file = encode_lossy(page, options.images, context);
    page.pixels = decode_image(page.file, "page", Maker::kThisProgram).pixels;
}

BakeResult finish(BakedTexture baked, std::vector<PageSize> pages, const Context& context) {
    report_progress(context, "texture", 1.0);
    BakeResult out;
    out.model = std::move(baked.model);
    out.debug_maps = std::move(baked.debug_maps);
    out.texture = baked.report;
    out.atlas.num_texels = num_texels(pages);
    const auto all = static_cast<double>(out.atlas.num_texels);
    out.atlas.fill = static_cast<double>(out.texture.num_needed_texels) / all;
    out.atlas.payload = out.texture.payload_texels / all;
    out.atlas.pages = std::move(pages);
    return out;
}

// Of width 0 if the material has no image.
GivenLayout::Page page_of_material(const TexturedMesh& given, Index material) {
    if (material >= given.materials.size()) return {"page0", {}};
    const Material& m = given.materials[material];
    const auto image = static_cast<std::size_t>(m.color_image);
    if (m.color_image < 0 || image >= given.images.size()) return {m.name, {}};
    return {m.name, {given.images[image].width, given.images[image].height}};
}

double bound_of(const TextureOptions& options) {
    return options.texture_error.value_or(options.texels ? HUGE_VAL : kDefaultTextureError);
}

BakeResult pack_and_bake(const Mesh& mesh, const PointCloud& cloud, std::span<const Index> owners,
                         const ConvertOptions& given, const Context& context) {
    ConvertOptions options = given;
    if (options.texture.paper) {
        options.texture.projection = Projection::kOrthographic;
        options.texture.atlas = AtlasKind::kTriangles;
        options.atlas.packer = Packer::kAppendixA;
    }
    if (options.texture.atlas == AtlasKind::kCharts) options.atlas.packer = Packer::kBitmap;
    TextureOptions texture = options.texture;
    texture.max_side = smallest_page_side(options);
    texture.max_patch = std::min(texture.max_patch, texture.max_side);
    const double bound = bound_of(texture);
    if (std::isfinite(bound)) texture.texture_error = bound;
    const TextureBaker baker(mesh, cloud, owners, texture, context);
    Fitted fitted = fit(baker, bound, options, context);
    report_progress(context, "texture", 0.85);
    BakedTexture baked = baker.bake(fitted.plan, bound, fitted.pages, fitted.placements, context);
    refine_in_place(baked, fitted, baker, bound, options, context);
    return finish(std::move(baked), std::move(fitted.pages), context);
}

BakeResult bake_into_layout(const Mesh& mesh, const PointCloud& cloud,
                            std::span<const Index> owners, const GivenLayout& layout,
                            const ConvertOptions& options, const Context& context) {
    std::vector<PageSize> proportions;
    for (const GivenLayout::Page& page : layout.pages) proportions.push_back(page.proportions);
    constexpr std::int64_t kNoBudget = std::numeric_limits<std::int64_t>::max();
    const std::int64_t texels = budget_of(options.texture);
    const GivenLimits limits{
        bound_of(options.texture),
        scaled_pages(proportions, texels > 0 ? texels : kNoBudget, options.atlas),
        texels > 0 &&
            num_texels(scaled_pages(proportions, kNoBudget, options.atlas).back()) > texels};
    const TextureBaker baker(mesh, cloud, owners, options.texture, context);
    GivenBake baked = baker.bake_given(layout, limits, context);
    BakeResult out = finish(std::move(baked.texture), std::move(baked.pages), context);
    if (baked.num_shared_texels > 0)
        out.warnings.push_back(
            fmt::format("--keep-uvs: {} texels lie in several triangles (a mirrored or repeated "
                        "layout); they show the first one's colours",
                        baked.num_shared_texels));
    if (baked.num_without_area > 0)
        out.warnings.push_back(fmt::format(
            "--keep-uvs: {} triangles cover no area of the layout or of space; they are "
            "not painted",
            baked.num_without_area));
    return out;
}

}  // namespace

GivenLayout given_layout(const std::optional<TexturedMesh>& mesh) {
    if (!mesh) fail(ErrorCode::kInvalidOption, "keep-uvs needs a mesh to keep them of");
    const TexturedMesh& given = *mesh;
    GivenLayout out;
    out.triangle_pages = given.triangle_materials;
    if (out.triangle_pages.empty()) out.triangle_pages.resize(given.mesh.triangles.size(), 0);
    std::vector<Index> page_of(std::max<std::size_t>(given.materials.size(), 1), kInvalidIndex);
    int largest = 1;
    for (Index& material : out.triangle_pages) {
        if (material >= page_of.size())
            fail(ErrorCode::kInvalidInput, "a triangle has material {}, but there are {}", material,
                 page_of.size());
        Index& page = page_of[material];
        if (page == kInvalidIndex) {
            page = static_cast<Index>(out.pages.size());
            out.pages.push_back(page_of_material(given, material));
            const PageSize p = out.pages.back().proportions;
            largest = std::max({largest, p.width, p.height});
        }
        material = page;
    }
    // Without an image: a square as large as the others.
    for (GivenLayout::Page& page : out.pages)
        if (page.proportions.width == 0) page.proportions = {largest, largest};
    validate(given.mesh, out);
    return out;
}

BakeResult bake_texture(const Mesh& mesh, const PointCloud& cloud, std::span<const Index> owners,
                        const std::optional<GivenLayout>& layout, const ConvertOptions& given,
                        const Context& context) {
    const bool is_color = !cloud.colors.empty();
    ConvertOptions options = given;
    options.texture.finish_page = [&](Image& page, std::span<const std::uint8_t> owned) {
        finish_page(page, owned, given, is_color, context);
    };
    BakeResult out = layout ? bake_into_layout(mesh, cloud, owners, *layout, options, context)
                            : pack_and_bake(mesh, cloud, owners, options, context);
    if (!is_color && given.images.format != ImageFormat::kPng)
        out.warnings.push_back(fmt::format("normal maps stay PNG: {} would bend the normals",
                                           to_word(given.images.format)));
    return out;
}

}  // namespace pointbake
