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

// pack() tries pages of growing size, from the sum of the shapes on. A step is this share of what
// the last pages had no room for (more could be too much, as larger pages also fill better), and at
// least kLeastGrowth. Once shapes fit, pages between the last two sizes are tried.
constexpr double kStep = 0.8;
constexpr double kLeastGrowth = 1.004;
constexpr int kNumRefinements = 5;

// Share of the free texels that lower shapes would still fill where a taller one does not fit.
constexpr double kUsefulShare = 0.9;

struct Attempt {
    std::vector<PageSize> pages;
    std::optional<Layout> layout;  // of all shapes, or nothing
    double num_missing = 0.0;      // texels that the pages lack, about
};

Attempt try_pages(const ShapeSet& shapes, std::vector<PageSize> pages, const AtlasOptions& options,
                  const Context& context) {
    Layout layout(pages, shapes.size());
    const bool is_paper = options.packer == Packer::kAppendixA;
    if ((is_paper ? pack_appendix_a : pack_rows)(shapes, layout, context))
        return {std::move(pages), std::move(layout), 0.0};
    std::int64_t placed = 0;
    for (int rank = 0; rank < shapes.size(); ++rank)
        if (layout.spot(rank).page != kUnplaced) placed += shapes[rank].num_texels;
    const auto free = static_cast<double>(num_texels(pages) - placed);
    return {std::move(pages), std::nullopt,
            static_cast<double>(shapes.num_texels() - placed) - kUsefulShare * free};
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
    std::vector<PageSize> sizes(pages.begin(), pages.end());
    if (set.num_texels() > num_texels(sizes)) return std::nullopt;
    const Attempt attempt = try_pages(set, std::move(sizes), options, context);
    if (!attempt.layout) return std::nullopt;
    return to_packing(set, *attempt.layout);
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
    const auto try_texels = [&](double texels) {
        return try_pages(
            set, pages_that_hold(static_cast<std::int64_t>(std::ceil(texels)), smallest, options),
            options, context);
    };
    const auto needed = static_cast<double>(set.num_texels());
    double too_few = 0.0;  // rooms that pages of this many texels have not
    Attempt best = try_texels(needed);
    while (!best.layout) {
        too_few = static_cast<double>(num_texels(best.pages));
        best = try_texels(std::max(kLeastGrowth * too_few, too_few + kStep * best.num_missing));
    }
    double enough = static_cast<double>(num_texels(best.pages));
    for (int i = 0; i < kNumRefinements && enough > kLeastGrowth * too_few && too_few > 0.0; ++i) {
        const double middle = 0.5 * (too_few + enough);
        const auto pages = pages_that_hold(static_cast<std::int64_t>(middle), smallest, options);
        if (num_texels(pages) == num_texels(best.pages)) {
            enough = middle;
            continue;
        }
        Attempt attempt = try_pages(set, pages, options, context);
        (attempt.layout ? enough : too_few) = static_cast<double>(num_texels(pages));
        if (attempt.layout) best = std::move(attempt);
    }
    return to_packing(set, *best.layout);
}

}  // namespace pointbake
