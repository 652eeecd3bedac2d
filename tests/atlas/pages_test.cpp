#include <gtest/gtest.h>

#include <bit>

#include "pointbake/atlas.h"
#include "pointbake/error.h"

namespace pointbake {
namespace {

std::int64_t sum(const std::vector<PageSize>& pages) {
    std::int64_t total = 0;
    for (const PageSize& page : pages) total += std::int64_t{page.width} * page.height;
    return total;
}

class BudgetPages : public testing::TestWithParam<std::tuple<int, bool>> {
 protected:
    const AtlasOptions options{.page_size = std::get<0>(GetParam()),
                               .power_of_two = std::get<1>(GetParam())};
};

TEST_P(BudgetPages, SpendTheBudgetOnFewPages) {
    const std::int64_t largest = std::int64_t{options.page_size} * options.page_size;
    std::vector<std::int64_t> budgets{4096,      5000,       262'144,     1'000'000,  1'048'576,
                                      4'194'304, 10'000'000, 100'000'000, 65'536 - 1, 67'108'864};
    for (std::int64_t n = 4096; n < 20'000'000; n += 1 + n / 13) budgets.push_back(n);
    for (const std::int64_t n : budgets) {
        const std::vector<PageSize> pages = budget_pages(n, options);
        SCOPED_TRACE(testing::Message() << n << " texels, " << pages.size() << " pages");
        ASSERT_FALSE(pages.empty());
        EXPECT_LE(sum(pages), n);
        // pages are made of units of 4096 texels: with fewer than 40, 0.9 may lie between two
        if (n >= 40 * 4096) {
            EXPECT_GE(static_cast<double>(sum(pages)), 0.9 * static_cast<double>(n));
        }
        EXPECT_GT(sum(pages), n / 2);
        if (n <= largest) {
            EXPECT_LE(pages.size(), 4U);
        } else {
            EXPECT_LE(static_cast<std::int64_t>(pages.size()), n / largest + 4);
        }
        for (const PageSize& page : pages) {
            EXPECT_LE(std::max(page.width, page.height), options.page_size);
            EXPECT_LE(page.width, 2 * page.height);
            EXPECT_LE(page.height, 2 * page.width);
            for (const int side : {page.width, page.height}) {
                EXPECT_EQ(side % 64, 0);
                if (options.power_of_two) {
                    EXPECT_EQ(side & (side - 1), 0);
                }
            }
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Sizes, BudgetPages,
                         testing::Combine(testing::Values(1024, 2048, 4096, 8192),
                                          testing::Bool()));

TEST(BudgetPagesOf, APowerOfFourAreOneSquare) {
    for (const bool pot : {false, true}) {
        const AtlasOptions options{.power_of_two = pot};
        for (const int side : {64, 512, 1024, 2048, 4096}) {
            const auto pages = budget_pages(std::int64_t{side} * side, options);
            ASSERT_EQ(pages.size(), 1U);
            EXPECT_EQ(pages[0].width, side);
            EXPECT_EQ(pages[0].height, side);
        }
    }
}

TEST(BudgetPagesOf, TooLittleAreRefused) {
    for (const std::int64_t n : {std::int64_t{0}, std::int64_t{4095}, std::int64_t{-5}}) {
        try {
            budget_pages(n, {});
            FAIL() << n;
        } catch (const Error& e) {
            EXPECT_EQ(e.code(), ErrorCode::kInvalidOption);
        }
    }
    EXPECT_EQ(sum(budget_pages(4096, {})), 4096);
}

TEST(ScaledPages, KeepProportionsAndUseTheBudget) {
    const std::vector<PageSize> proportions{{200, 100}, {100, 100}};
    for (const std::int64_t budget : {50'000, 100'000, 250'000, 1'000'000, 5'000'000}) {
        const auto sizes = scaled_pages(proportions, budget, {});
        for (std::size_t i = 0; i + 1 < sizes.size(); ++i)
            EXPECT_LT(num_texels(sizes[i]), num_texels(sizes[i + 1]));
        const std::vector<PageSize>& last = sizes.back();
        ASSERT_EQ(last.size(), 2U);
        EXPECT_LE(num_texels(last), budget);
        EXPECT_GE(static_cast<double>(num_texels(last)), 0.8 * static_cast<double>(budget));
        EXPECT_NEAR(static_cast<double>(last[0].width) / last[0].height, 2.0, 0.5);
    }
    const auto powers = scaled_pages(proportions, 1'000'000, {.power_of_two = true});
    for (const PageSize page : powers.back()) {
        EXPECT_TRUE(std::has_single_bit(static_cast<unsigned>(page.width)));
        EXPECT_TRUE(std::has_single_bit(static_cast<unsigned>(page.height)));
    }
    EXPECT_EQ(scaled_pages(proportions, 1LL << 40, {.page_size = 1000}).back()[0].width, 960);
    EXPECT_THROW(scaled_pages(proportions, 8191, {}), Error);
    EXPECT_THROW(scaled_pages(proportions, 1 << 20, {.page_size = 20}), Error);
}

}  // namespace
}  // namespace pointbake
