// Shapes are packed into pages of a given size; without a size, the smallest pages that hold them
// are searched for.
#include "pointbake/atlas.h"

#include <algorithm>
#include <cmath>

#include "atlas/appendix_a.h"
#include "atlas/bitmap.h"
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

using Placements = std::vector<Placement>;

Placements to_placements(const ShapeSet& shapes, const Layout& layout) {
    Placements out(layout.spots.size());
    for (int rank = 0; rank < shapes.size(); ++rank) {
        const Spot& spot = layout.spot(rank);
        out[shapes[rank].shape] = {static_cast<Index>(spot.page), spot.x, spot.y,
                                   is_mirrored_x(spot.pose), is_mirrored_y(spot.pose)};
    }
    return out;
}

// Tries pages for one set of shapes.
class Tries {
 public:
    Tries(std::span<const PatchShape> shapes, const AtlasOptions& options, const Context& context)
        : shapes_(shapes), packer_(options.packer), context_(context) {
        if (packer_ != Packer::kBitmap) set_.emplace(shapes);
        for (const PatchShape& shape : shapes) {
            num_needed_ += shape.num_texels();
            smallest_.width = std::max(smallest_.width, shape.width());
            smallest_.height = std::max(smallest_.height, shape.height());
        }
    }

    std::int64_t num_needed() const { return num_needed_; }
    /// That has room for each of the shapes.
    PageSize smallest_page() const { return smallest_; }

    std::optional<Packing> into(std::span<const PageSize> pages) const {
        if (num_needed_ > num_texels(pages)) return std::nullopt;
        std::optional<Placements> placements = place(pages);
        if (!placements) return std::nullopt;
        return Packing{
            {pages.begin(), pages.end()}, std::move(*placements), num_needed_, num_texels(pages)};
    }

 private:
    std::optional<Placements> place(std::span<const PageSize> pages) const {
        if (packer_ == Packer::kBitmap) return pack_bitmap(shapes_, pages, context_);
        Layout layout(pages, set_->size());
        const bool has_room = packer_ == Packer::kAppendixA
                                  ? pack_appendix_a(*set_, layout, context_)
                                  : pack_rows(*set_, layout, context_);
        if (!has_room) return std::nullopt;
        return to_placements(*set_, layout);
    }

    std::span<const PatchShape> shapes_;
    Packer packer_;
    const Context& context_;
    std::optional<ShapeSet> set_;
    std::int64_t num_needed_ = 0;
    PageSize smallest_;
};

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
    // Bitmaps may be turned.
    if (options.packer == Packer::kBitmap)
        largest.width = largest.height = std::max(largest.width, largest.height);
    validate(shapes, largest);
    check_cancelled(context);
    return Tries(shapes, options, context).into(pages);
}

Packing pack(std::span<const PatchShape> shapes, const AtlasOptions& options,
             const Context& context) {
    validate(options);
    const int side = largest_side(options);
    validate(shapes, {side, side});
    check_cancelled(context);
    if (shapes.empty()) return {};
    const Tries tries(shapes, options, context);
    const auto pages_for = [&](double texels) {
        return pages_that_hold(static_cast<std::int64_t>(std::ceil(texels)), tries.smallest_page(),
                               options);
    };
    auto too_few = static_cast<double>(tries.num_needed());
    double enough = too_few / kFirstFill;
    std::optional<Packing> best;
    while (!(best = tries.into(pages_for(enough)))) {
        too_few = enough;
        enough /= kFillStep;
    }
    for (int i = 0; i < kNumRefinements; ++i) {
        const double middle = 0.5 * (too_few + enough);
        const std::vector<PageSize> pages = pages_for(middle);
        std::optional<Packing> packing;
        if (num_texels(pages) != best->num_texels) packing = tries.into(pages);
        if (packing) best = std::move(packing);
        const bool fits = num_texels(pages) == best->num_texels;
        (fits ? enough : too_few) = middle;
    }
    return std::move(*best);
}

}  // namespace pointbake
