#include "atlas/pages.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

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

bool is_within(PageSize inner, PageSize outer) {
    return inner.width <= outer.width && inner.height <= outer.height;
}

// Of width 0 if none holds that many.
PageSize smallest_page_for(std::int64_t texels, PageSize smallest, const std::vector<int>& sides) {
    const auto holds = [&](PageSize page) {
        return num_texels(page) >= texels && is_within(smallest, page);
    };
    return best_page(sides, holds, std::less<>{});
}

// `count` pages below the number of texels, and one more that holds the rest; none if that is not
// possible.
std::vector<PageSize> split_page(std::int64_t texels, int count, const std::vector<int>& sides) {
    std::vector<PageSize> parts;
    for (int i = 0; i < count; ++i) {
        if (texels < kSmallestPage) return {};
        parts.push_back(largest_page_within(texels, sides));
        texels -= num_texels(parts.back());
    }
    if (texels > 0) parts.push_back(smallest_page_for(texels, {}, sides));
    return parts;
}

using Pages = std::vector<PageSize>;

// The proportions at a longest side, each rounded to the nearest side that there is.
Pages scaled(std::span<const PageSize> proportions, double longest, const std::vector<int>& sides) {
    int whole = 1;
    for (const PageSize& p : proportions) whole = std::max({whole, p.width, p.height});
    const auto nearest = [&](int length) {
        const double wanted = longest * length / whole;
        return *std::min_element(sides.begin(), sides.end(), [&](int a, int b) {
            return std::fabs(a - wanted) < std::fabs(b - wanted);
        });
    };
    Pages out;
    for (const PageSize& p : proportions) out.push_back({nearest(p.width), nearest(p.height)});
    return out;
}

// Single sides take the next step while that keeps the budget: they are read as texture
// coordinates say, whatever their proportions.
void lengthen_in_place(Pages& pages, std::int64_t texels, const std::vector<int>& sides) {
    for (PageSize& page : pages) {
        for (int* side : {&page.height, &page.width}) {
            const auto next = std::upper_bound(sides.begin(), sides.end(), *side);
            if (next == sides.end()) continue;
            const int before = std::exchange(*side, *next);
            if (num_texels(pages) > texels) *side = before;
        }
    }
}

}  // namespace

std::vector<Pages> scaled_pages(std::span<const PageSize> proportions, std::int64_t texels,
                                const AtlasOptions& options) {
    validate(options);
    const std::vector<int> all = sides(options);
    const Pages smallest = scaled(proportions, all.front(), all);
    if (num_texels(smallest) > texels)
        fail(ErrorCode::kLimit, "a budget of {} texels: the smallest pages of this layout have {}",
             texels, num_texels(smallest));
    auto largest = all.end() - 1;
    while (num_texels(scaled(proportions, *largest, all)) > texels) --largest;
    std::vector<Pages> out{smallest};
    for (int step = 1;; ++step) {
        const double side =
            std::ldexp(step % 2 == 1 ? 1.4142135623730951 : 1.0, step / 2) * all.front();
        if (side >= *largest) break;
        Pages pages = scaled(proportions, side, all);
        if (num_texels(pages) > num_texels(out.back())) out.push_back(std::move(pages));
    }
    Pages last = scaled(proportions, *largest, all);
    lengthen_in_place(last, texels, all);
    if (num_texels(last) > num_texels(out.back())) out.push_back(std::move(last));
    return out;
}

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

std::vector<PageSize> pages_that_hold(std::int64_t texels, PageSize smallest,
                                      const AtlasOptions& options) {
    const std::vector<int> all = sides(options);
    const PageSize full{all.back(), all.back()};
    std::vector<PageSize> pages;
    for (; texels > num_texels(full); texels -= num_texels(full)) pages.push_back(full);
    // once there is a full page, the others need not take the largest shapes
    if (!pages.empty()) smallest = {};
    const PageSize one = smallest_page_for(texels, smallest, all);
    std::vector<PageSize> best{one.width > 0 ? one : full};
    for (int split = 1; options.power_of_two && split < kMaxSplit; ++split) {
        const std::vector<PageSize> parts = split_page(texels, split, all);
        if (!parts.empty() && is_within(smallest, parts.front()) &&
            static_cast<double>(num_texels(parts)) <=
                kEnough * static_cast<double>(num_texels(best)))
            best = parts;
    }
    pages.insert(pages.end(), best.begin(), best.end());
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
