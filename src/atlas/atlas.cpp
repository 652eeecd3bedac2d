// Shapes are packed into pages of a given size; without a size, the smallest pages that hold them
// are searched for.
#include "pointbake/atlas.h"

#include <algorithm>
#include <cmath>

#include "atlas/appendix_a.h"
#include "atlas/gaps.h"
#include "atlas/layout.h"
#include "atlas/pages.h"
#include "atlas/rows.h"
#include "core/message.h"
#include "core/parallel.h"

namespace pointbake {
namespace {

// pack() tries pages of growing size, from the sum of the shapes on. A step is this share of what
// the last pages had no room for (more could be too much, as larger pages also fill better), and at
// least kLeastGrowth.
constexpr double kStep = 0.8;
constexpr double kLeastGrowth = 1.004;

// A style of rows that leaves more than this share of the texels unplaced is not worth repairing,
// neither by gaps nor by another style: more rarely fits in the end.
constexpr double kHopeless = 0.02;

// Tried in turn; mostly the first is the best, and the others gain a percent where it is not.
constexpr RowStyle kStyles[] = {{}, {2.0, 0.8}};

std::int64_t num_unplaced_texels(const ShapeSet& shapes, const Layout& layout) {
    std::int64_t sum = 0;
    for (int rank = 0; rank < shapes.size(); ++rank)
        if (layout.spot(rank).page == kUnplaced) sum += shapes[rank].num_texels;
    return sum;
}

struct Attempt {
    std::optional<Layout> layout;   // of all shapes, or nothing
    std::int64_t num_unplaced = 0;  // texels for which the best style had no room
};

Attempt try_pages(const ShapeSet& shapes, std::span<const PageSize> pages,
                  const AtlasOptions& options, const Context& context) {
    Attempt out{std::nullopt, shapes.num_texels()};
    const auto hopeless =
        static_cast<std::int64_t>(kHopeless * static_cast<double>(shapes.num_texels()));
    for (const RowStyle& style : kStyles) {
        Layout layout(pages, shapes.size());
        const bool is_paper = options.packer == Packer::kAppendixA;
        if (is_paper)
            pack_appendix_a(shapes, layout, context);
        else
            pack_rows(shapes, style, layout, context);
        const std::int64_t unplaced = num_unplaced_texels(shapes, layout);
        out.num_unplaced = std::min(out.num_unplaced, unplaced);
        if (unplaced == 0 ||
            (!is_paper && unplaced <= hopeless && fill_gaps(shapes, layout, context))) {
            out.layout = std::move(layout);
            return out;
        }
        if (is_paper || unplaced > hopeless) break;
    }
    return out;
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
    std::int64_t room = 0;
    for (const PageSize& page : pages) room += num_texels(page);
    if (set.num_texels() > room) return std::nullopt;
    const Attempt attempt = try_pages(set, pages, options, context);
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
    const auto needed = static_cast<double>(set.num_texels());
    std::int64_t tried = 0;
    for (double texels = needed;;) {
        const std::vector<PageSize> pages =
            pages_that_hold(static_cast<std::int64_t>(std::ceil(texels)), smallest, options);
        const std::int64_t room = num_texels(pages);
        texels *= kLeastGrowth;
        if (room == tried) continue;
        tried = room;
        const Attempt attempt = try_pages(set, pages, options, context);
        if (attempt.layout) return to_packing(set, *attempt.layout);
        const double missing = static_cast<double>(attempt.num_unplaced) / needed;
        texels = std::max(texels, static_cast<double>(room) * (1.0 + kStep * missing));
    }
}

}  // namespace pointbake
