#include "atlas/pages.h"

#include <algorithm>
#include <bit>

#include "core/message.h"

namespace pointbake {
namespace {

// Longer pages leave more waste at the ends of rows (or of columns).
constexpr int kLongestAspect = 2;

// A page more is worth it if it buys this share of the budget.
constexpr double kEnough = 0.95;
constexpr int kMaxSplit = 4;

constexpr std::int64_t kSmallestPage = std::int64_t{kPageUnit} * kPageUnit;

// Sides that a page may have, ascending.
std::vector<int> sides(const AtlasOptions& options) {
    std::vector<int> out;
    const int largest = largest_side(options);
    for (int side = kPageUnit; side <= largest;
         side = options.power_of_two ? 2 * side : side + kPageUnit)
        out.push_back(side);
    return out;
}

// The page that `is_better` likes best among those of nearly square shape that `is_allowed`.
template <class Allowed, class Better>
PageSize best_page(const std::vector<int>& sides, Allowed&& is_allowed, Better&& is_better) {
    PageSize best;
    for (const int height : sides) {
        for (const int width : sides) {
            if (width < height) continue;
            if (width > kLongestAspect * height) break;
            const PageSize page{width, height};
            if (!is_allowed(page)) continue;
            if (best.width == 0 || is_better(num_texels(page), num_texels(best)) ||
                (num_texels(page) == num_texels(best) && width < best.width))
                best = page;
        }
    }
    return best;
}

PageSize largest_page_within(std::int64_t texels, const std::vector<int>& sides) {
    return best_page(
        sides, [&](PageSize page) { return num_texels(page) <= texels; }, std::greater<>{});
}

}  // namespace

void validate(const AtlasOptions& options) {
    if (options.page_size < kPageUnit || options.page_size > kLargestPageSize)
        fail(ErrorCode::kInvalidOption, "page-size is {}; {} to {} texels are accepted",
             options.page_size, kPageUnit, kLargestPageSize);
}

int largest_side(const AtlasOptions& options) {
    if (options.power_of_two)
        return static_cast<int>(std::bit_floor(static_cast<unsigned>(options.page_size)));
    return options.page_size / kPageUnit * kPageUnit;
}

std::int64_t num_texels(const std::vector<PageSize>& pages) {
    std::int64_t sum = 0;
    for (const PageSize& page : pages) sum += num_texels(page);
    return sum;
}

std::vector<PageSize> pages_that_hold(std::int64_t texels, PageSize smallest,
                                      const AtlasOptions& options) {
    const std::vector<int> all = sides(options);
    const PageSize full{all.back(), all.back()};
    std::vector<PageSize> pages;
    for (; texels > num_texels(full); texels -= num_texels(full)) pages.push_back(full);
    const auto holds = [&](PageSize page) {
        return num_texels(page) >= texels && page.width >= smallest.width &&
               page.height >= smallest.height;
    };
    pages.push_back(best_page(all, holds, std::less<>{}));
    if (pages.back().width == 0) pages.back() = full;
    return pages;
}

std::vector<PageSize> budget_pages(std::int64_t texels, const AtlasOptions& options) {
    validate(options);
    if (texels < kSmallestPage)
        fail(ErrorCode::kInvalidOption,
             "a budget of {} texels buys no page; at least {} texels ({} x {}) are accepted",
             texels, kSmallestPage, kPageUnit, kPageUnit);
    const std::vector<int> all = sides(options);
    const PageSize full{all.back(), all.back()};
    std::vector<PageSize> pages;
    std::int64_t left = texels;
    for (; left >= num_texels(full); left -= num_texels(full)) pages.push_back(full);
    const auto enough = static_cast<std::int64_t>(kEnough * static_cast<double>(texels));
    for (int i = 0; i < kMaxSplit && left >= kSmallestPage && texels - left < enough; ++i) {
        pages.push_back(largest_page_within(left, all));
        left -= num_texels(pages.back());
    }
    return pages;
}

}  // namespace pointbake
