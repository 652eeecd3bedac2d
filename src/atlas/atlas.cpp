// Shapes are packed into pages of a given size; without a size, the smallest pages that hold them
// are searched for.
#include "pointbake/atlas.h"

#include <algorithm>
#include <cmath>

#include "atlas/appendix_a.h"
#include "atlas/layout.h"
#include "atlas/pages.h"
#include "atlas/rows.h"
#include "core/message.h"
#include "core/parallel.h"

namespace pointbake {
namespace {

// pack() tries pages that shapes would fill to this share, lowers it by a step until they fit, and
// halves the interval between the last two sizes as often as here said: the fill is within a
// percent of what can be had.
constexpr double kFirstFill = 0.93;
constexpr double kFillStep = 0.85;
constexpr int kNumRefinements = 4;

std::optional<Layout> try_pages(const ShapeSet& shapes, std::span<const PageSize> pages,
                                const AtlasOptions& options, const Context& context) {
    Layout layout(pages, shapes.size());
    const bool has_room = options.packer == Packer::kAppendixA
                              ? pack_appendix_a(shapes, layout, context)
                              : pack_rows(shapes, layout, context);
    if (!has_room) return std::nullopt;
    return layout;
}

Packing to_packing(const ShapeSet& shapes, const Layout& layout) {
    Packing out;
    out.pages = layout.pages;
    out.placements.resize(layout.spots.size());
    for (int rank = 0; rank < shapes.size(); ++rank) {
        const Spot& spot = layout.spot(rank);
        out.placements[shapes[rank].shape] = {static_cast<Index>(spot.page), spot.x, spot.y,
                                              is_mirrored_x(spot.pose), is_mirrored_y(spot.pose)};
    }
    out.num_needed = shapes.num_texels();
    out.num_texels = num_texels(layout.pages);
    return out;
}

}  // namespace

std::optional<Packing> pack_into(std::span<const PatchShape> shapes,
                                 std::span<const PageSize> pages, const AtlasOptions& options,
                                 const Context& context) {
    validate(options);
    PageSize largest;
    for (const PageSize& page : pages) {
        if (page.width < 1 || page.height < 1 || page.width > kLargestPageSize ||
            page.height > kLargestPageSize)
            fail(ErrorCode::kInvalidOption, "a page is {} x {}; 1 to {} texels are accepted",
                 page.width, page.height, kLargestPageSize);
        largest.width = std::max(largest.width, page.width);
        largest.height = std::max(largest.height, page.height);
    }
    validate(shapes, largest);
    check_cancelled(context);
    const ShapeSet set(shapes);
    if (set.num_texels() > num_texels(pages)) return std::nullopt;
    const std::optional<Layout> layout = try_pages(set, pages, options, context);
    if (!layout) return std::nullopt;
    return to_packing(set, *layout);
}

Packing pack(std::span<const PatchShape> shapes, const AtlasOptions& options,
             const Context& context) {
    validate(options);
    const int side = largest_side(options);
    validate(shapes, {side, side});
    check_cancelled(context);
    const ShapeSet set(shapes);
    if (set.size() == 0) return {};
    const PageSize smallest{set.max_width(), set.max_height()};
    const auto pages_for = [&](double texels) {
        return pages_that_hold(static_cast<std::int64_t>(std::ceil(texels)), smallest, options);
    };
    double too_few = static_cast<double>(set.num_texels());
    double enough = too_few / kFirstFill;
    std::optional<Layout> best;
    while (!(best = try_pages(set, pages_for(enough), options, context))) {
        too_few = enough;
        enough /= kFillStep;
    }
    for (int i = 0; i < kNumRefinements; ++i) {
        const double middle = 0.5 * (too_few + enough);
        const std::vector<PageSize> pages = pages_for(middle);
        std::optional<Layout> layout;
        if (num_texels(pages) != num_texels(best->pages))
            layout = try_pages(set, pages, options, context);
        if (layout) best = std::move(layout);
        const bool fits = num_texels(pages) == num_texels(best->pages);
        (fits ? enough : too_few) = middle;
    }
    return to_packing(set, *best);
}

}  // namespace pointbake
