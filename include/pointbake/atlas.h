// Stage 6: patches are packed into pages.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "pointbake/context.h"
#include "pointbake/options.h"
#include "pointbake/patch.h"
#include "pointbake/types.h"

namespace pointbake {

enum class Packer { kLeastWaste, kAppendixA, kBitmap };
template <>
struct EnumWords<Packer> {
    static constexpr std::string_view words[] = {"least-waste", "appendix-a", "bitmap"};
};

struct AtlasOptions {
    int page_size = 4096;
    bool power_of_two = false;
    Packer packer = Packer::kLeastWaste;
    template <class Field>
    static void describe(Field&& field) {
        field("page-size", &AtlasOptions::page_size,
              "largest width and height of a page, in texels");
        field("pot", &AtlasOptions::power_of_two, "pages whose sides are powers of two");
        field("packer", &AtlasOptions::packer, "least-waste rows, or the paper's Appendix A");
    }
};

struct Packing {
    std::vector<PageSize> pages;
    std::vector<Placement> placements;  ///< one per shape
    std::int64_t num_needed = 0;        ///< texels that the shapes need
    std::int64_t num_texels = 0;        ///< texels of the pages
    double fill() const {
        return num_texels ? static_cast<double>(num_needed) / static_cast<double>(num_texels) : 0.0;
    }
};

/// Packs all shapes into as few pages as needed, each at most page_size wide and high, sides
/// multiples of 64 (powers of two with `pot`). No two need sets share a texel. Rows stay open
/// (algorithms 7.3). Deterministic; ties by position in `shapes`. Throws Error{kLimit} if a shape
/// is larger than a page.
Packing pack(std::span<const PatchShape> shapes, const AtlasOptions& options = {},
             const Context& context = {});

/// The pages a budget of `texels` buys: sides multiples of 64 (or powers of two), at most
/// page_size, nearly square, as few as possible (at most 4 where one page could hold the budget),
/// their sum at most `texels` and at least 0.9 of it where that can be. Throws
/// Error{kInvalidOption} below the smallest page (64 x 64).
std::vector<PageSize> budget_pages(std::int64_t texels, const AtlasOptions& options);

/// Sizes of pages whose proportions are given, all scaled alike, small to large: the longest side
/// grows by sqrt(2), and the last sizes are the largest that page_size and a budget of `texels` for
/// all together allow. Throws Error{kInvalidOption} for a page_size out of range, Error{kLimit} if
/// the smallest pages are over the budget.
std::vector<std::vector<PageSize>> scaled_pages(std::span<const PageSize> proportions,
                                                std::int64_t texels, const AtlasOptions& options);

/// Packs into the given pages; std::nullopt if they do not all fit.
std::optional<Packing> pack_into(std::span<const PatchShape> shapes,
                                 std::span<const PageSize> pages, const AtlasOptions& options = {},
                                 const Context& context = {});

/// Fills the texels that no patch owns by pull-push, so that mip-mapping bleeds only like colours.
/// `owned` has one byte per texel. Filtering is in linear light for sRGB images.
void fill_unowned_in_place(Image& page, std::span<const std::uint8_t> owned,
                           const Context& context = {});

}  // namespace pointbake
