#include <gtest/gtest.h>

#include <cmath>

#include "core/color.h"
#include "core/hash.h"
#include "pointbake/atlas.h"
#include "pointbake/error.h"

namespace pointbake {
namespace {

struct Page {
    Image image;
    std::vector<std::uint8_t> owned;
};

// A share of texels, in blocks, is owned and has colours; the rest holds garbage.
template <class Color>
Page make_page(int width, int height, int channels, double share, Color&& color) {
    Page page{{width, height, channels, {}}, {}};
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const auto block = static_cast<std::uint64_t>((y / 3) * 10'000 + x / 5);
            const bool owned = random_unit(1, block) < share;
            page.owned.push_back(owned ? 1 : 0);
            for (int c = 0; c < channels; ++c)
                page.image.pixels.push_back(
                    owned ? static_cast<std::uint8_t>(color(x, y, c))
                          : static_cast<std::uint8_t>(hash64(2, block) & 255U));
        }
    }
    return page;
}

TEST(FillUnowned, LeavesOwnedTexelsAlone) {
    for (const auto& [w, h] : {std::pair{64, 64}, {192, 128}, {67, 33}, {1, 50}, {50, 1}}) {
        Page page = make_page(w, h, 3, 0.5, [](int x, int y, int c) { return x * 3 + y * 5 + c; });
        const Image before = page.image;
        fill_unowned_in_place(page.image, page.owned);
        for (std::size_t i = 0; i < before.pixels.size(); ++i) {
            if (page.owned[i / 3] != 0) {
                ASSERT_EQ(page.image.pixels[i], before.pixels[i]);
            }
        }
    }
}

TEST(FillUnowned, KeepsAConstantColorConstant) {
    for (const int channels : {1, 2, 3, 4}) {
        for (int value = 0; value < 256; value += 5) {
            Page page = make_page(40, 72, channels, 0.3, [&](int, int, int) { return value; });
            fill_unowned_in_place(page.image, page.owned);
            for (const std::uint8_t p : page.image.pixels) ASSERT_EQ(p, value);
        }
    }
}

TEST(FillUnowned, StaysWithinTheColorsAround) {
    Page page =
        make_page(128, 128, 3, 0.2, [](int x, int y, int c) { return 60 + x / 2 + y / 4 + c; });
    fill_unowned_in_place(page.image, page.owned);
    for (const std::uint8_t p : page.image.pixels) {
        ASSERT_GE(p, 60);
        ASSERT_LE(p, 60 + 63 + 31 + 2);
    }
    // and near the colours that would continue them
    double worst = 0.0;
    for (int y = 20; y < 108; ++y)
        for (int x = 20; x < 108; ++x)
            worst = std::max(
                worst, std::fabs(60 + x / 2 + y / 4 -
                                 page.image.pixels[static_cast<std::size_t>((y * 128 + x) * 3)]));
    EXPECT_LT(worst, 25.0);
}

TEST(FillUnowned, MipLevelsShowWhatIsOwned) {
    // Cells of 16 x 16 texels with a strip in two colours, the rest free: box-filtered, each cell
    // has the mean of its strip, which the colours in its halves alone do not have.
    constexpr int kSize = 64, kCell = 16;
    Page page{{kSize, kSize, 1, {}}, {}};
    double wanted = 0.0, count = 0.0;
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x) {
            const bool owned = x % kCell < 10 && y % kCell < 6;
            const std::uint8_t code = x % kCell < 8 ? 150 : 240;
            page.owned.push_back(owned ? 1 : 0);
            page.image.pixels.push_back(code);
            if (owned) wanted += srgb_to_linear_exact(code / 255.0), count += 1.0;
        }
    fill_unowned_in_place(page.image, page.owned);
    for (int cy = 0; cy < kSize; cy += kCell)
        for (int cx = 0; cx < kSize; cx += kCell) {
            double mean = 0.0;
            for (int y = cy; y < cy + kCell; ++y)
                for (int x = cx; x < cx + kCell; ++x)
                    mean +=
                        srgb_to_linear_exact(
                            page.image.pixels[static_cast<std::size_t>(y * kSize + x)] / 255.0) /
                        (kCell * kCell);
            EXPECT_NEAR(mean, wanted / count, 0.01);
        }
}

TEST(FillUnowned, AveragesLightNotCodes) {
    // black and white halves far from the middle texels: the mean of their light is code 188
    Page page = make_page(2, 2, 1, 0.0, [](int, int, int) { return 0; });
    page.image.pixels = {0, 255, 77, 77};
    page.owned = {1, 1, 0, 0};
    fill_unowned_in_place(page.image, page.owned);
    EXPECT_EQ(page.image.pixels[2], linear_to_srgb8(0.5F));
    EXPECT_EQ(page.image.pixels[3], 188);
}

TEST(FillUnowned, LeavesAPageThatNobodyOwnsAlone) {
    Page page = make_page(32, 32, 3, 0.0, [](int, int, int) { return 0; });
    const auto before = page.image.pixels;
    fill_unowned_in_place(page.image, page.owned);
    EXPECT_EQ(page.image.pixels, before);
    Image none;
    fill_unowned_in_place(none, {});
}

TEST(FillUnowned, IsTheSameForAnyNumberOfThreads) {
    const Page page = make_page(300, 211, 3, 0.4, [](int x, int y, int c) { return x * y + c; });
    Context one, seven;
    one.threads = 1;
    seven.threads = 7;
    Image a = page.image, b = page.image;
    fill_unowned_in_place(a, page.owned, one);
    fill_unowned_in_place(b, page.owned, seven);
    EXPECT_EQ(a.pixels, b.pixels);
}

TEST(FillUnowned, RefusesArraysThatDoNotMatch) {
    Page page = make_page(8, 8, 3, 0.5, [](int, int, int) { return 9; });
    page.owned.pop_back();
    EXPECT_THROW(fill_unowned_in_place(page.image, page.owned), Error);
    page.owned.push_back(1);
    page.image.num_channels = 5;
    EXPECT_THROW(fill_unowned_in_place(page.image, page.owned), Error);
}

TEST(FillUnowned, StopsWhenTold) {
    std::stop_source source;
    source.request_stop();
    Context context;
    context.stop = source.get_token();
    Page page = make_page(64, 64, 3, 0.5, [](int, int, int) { return 9; });
    EXPECT_THROW(fill_unowned_in_place(page.image, page.owned, context), Error);
}

}  // namespace
}  // namespace pointbake
