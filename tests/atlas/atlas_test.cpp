#include "pointbake/atlas.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <numeric>

#include "atlas/random_shapes.h"
#include "pointbake/error.h"

namespace pointbake {
namespace {

bool is_gap(const PatchShape& shape, int i, int j) {
    return std::any_of(shape.gaps.begin(), shape.gaps.end(), [&](const PatchShape::Gap& gap) {
        return gap.row == j && i >= gap.span.left && i <= gap.span.right;
    });
}

// Every needed texel lies in a page, and no two shapes own the same.
void expect_valid(const std::vector<PatchShape>& shapes, const Packing& packing) {
    ASSERT_EQ(packing.placements.size(), shapes.size());
    std::vector<std::vector<std::uint8_t>> owned;
    std::int64_t num_texels = 0, num_needed = 0;
    for (const PageSize& page : packing.pages) {
        owned.emplace_back(static_cast<std::size_t>(page.width * page.height), std::uint8_t{0});
        num_texels += std::int64_t{page.width} * page.height;
    }
    for (std::size_t s = 0; s < shapes.size(); ++s) {
        const Placement& at = packing.placements[s];
        ASSERT_LT(at.page, packing.pages.size());
        const PageSize page = packing.pages[at.page];
        const int w = shapes[s].width(), h = shapes[s].height();
        num_needed += shapes[s].num_texels();
        for (int j = 0; j < h; ++j) {
            const PatchShape::Span row = shapes[s].rows[static_cast<std::size_t>(j)];
            for (int i = row.left; i <= row.right; ++i) {
                if (is_gap(shapes[s], i, j)) continue;
                const int across = at.mirror_x ? w - 1 - i : i;
                const int down = at.mirror_y ? h - 1 - j : j;
                const int x = at.x + (at.transposed ? down : across);
                const int y = at.y + (at.transposed ? across : down);
                ASSERT_TRUE(x >= 0 && x < page.width && y >= 0 && y < page.height) << "shape " << s;
                std::uint8_t& texel = owned[at.page][static_cast<std::size_t>(y * page.width + x)];
                ASSERT_EQ(texel, 0) << "shape " << s << " at " << x << ' ' << y;
                texel = 1;
            }
        }
    }
    EXPECT_EQ(packing.num_needed, num_needed);
    EXPECT_EQ(packing.num_texels, num_texels);
}

void expect_sides(const Packing& packing, const AtlasOptions& options) {
    for (const PageSize& page : packing.pages) {
        for (const int side : {page.width, page.height}) {
            EXPECT_LE(side, options.page_size);
            EXPECT_EQ(side % 64, 0);
            if (options.power_of_two) {
                EXPECT_EQ(side & (side - 1), 0);
            }
        }
    }
}

std::vector<PatchShape> repeated(int count, const PatchShape& shape) {
    return std::vector<PatchShape>(static_cast<std::size_t>(count), shape);
}

double fill_of_paper(const std::vector<PatchShape>& shapes) {
    return pack(shapes, {.packer = Packer::kAppendixA}).fill();
}

TEST(Pack, KeepsShapesApartInSetsOfAnySize) {
    for (const int count : {1, 2, 3, 10, 100, 1000, 5000}) {
        for (const Packer packer : {Packer::kLeastWaste, Packer::kAppendixA}) {
            for (const bool pot : {false, true}) {
                const AtlasOptions options{
                    .page_size = 1024, .power_of_two = pot, .packer = packer};
                const auto shapes =
                    log_normal_shapes(count, 10, 0.7, static_cast<std::uint64_t>(count));
                const Packing packing = pack(shapes, options);
                expect_valid(shapes, packing);
                expect_sides(packing, options);
            }
        }
    }
}

// A disc of texels, with a hole.
PatchShape ring(int radius, int hole) {
    const int side = 2 * radius + 1;
    std::vector<std::uint8_t> marked;
    for (int y = -radius; y <= radius; ++y)
        for (int x = -radius; x <= radius; ++x) {
            const int d2 = x * x + y * y;
            marked.push_back(d2 <= radius * radius && d2 >= hole * hole ? 1 : 0);
        }
    return need_set(marked, side).shape;
}

PatchShape rectangle(int width, int height) {
    const std::vector<std::uint8_t> marked(static_cast<std::size_t>(width * height), 1);
    return need_set(marked, width).shape;
}

constexpr AtlasOptions kBitmap{.page_size = 1024, .packer = Packer::kBitmap};

TEST(PackBitmap, KeepsShapesOfAnyKindApart) {
    std::vector<PatchShape> shapes;
    for (int i = 0; i < 60; ++i) {
        shapes.push_back(ring(4 + i % 23, i % 5));
        shapes.push_back(rectangle(1 + (7 * i) % 31, 1 + (11 * i) % 17));
    }
    for (const PatchShape& shape : log_normal_shapes(200, 12, 0.6)) shapes.push_back(shape);
    const Packing packing = pack(shapes, kBitmap);
    expect_valid(shapes, packing);
    expect_sides(packing, kBitmap);
    EXPECT_GT(packing.fill(), 0.8);
}

TEST(PackBitmap, LaysShapesIntoHolesOfOthers) {
    // The ring takes the whole page, and its hole the discs.
    std::vector<PatchShape> shapes{ring(31, 20)};
    for (int i = 0; i < 4; ++i) shapes.push_back(ring(7, 0));
    const auto packing = pack_into(shapes, std::vector{PageSize{63, 63}}, kBitmap);
    ASSERT_TRUE(packing);
    expect_valid(shapes, *packing);
}

TEST(PackBitmap, TurnsShapesThatFitNoOtherWay) {
    const std::vector<PatchShape> shapes{rectangle(20, 100), rectangle(100, 20)};
    const auto packing = pack_into(shapes, std::vector{PageSize{100, 40}}, kBitmap);
    ASSERT_TRUE(packing);
    expect_valid(shapes, *packing);
    EXPECT_TRUE(packing->placements[0].transposed);
}

TEST(PackBitmap, PacksLargePagesByBlocks) {
    std::vector<PatchShape> shapes = log_normal_shapes(60, 250, 0.3);
    for (int i = 0; i < 24; ++i) {
        shapes.push_back(ring(90 + 7 * (i % 9), 40));
        shapes.push_back(rectangle(101 + 13 * i, 307 - 9 * i));
    }
    const AtlasOptions options{.page_size = 4096, .packer = Packer::kBitmap};
    const Packing packing = pack(shapes, options);
    ASSERT_GT(packing.pages[0].width, 1024);
    expect_valid(shapes, packing);
    EXPECT_GT(packing.fill(), 0.7);
}

TEST(PackBitmap, MirroredShapesEndWithTheirBlocks) {
    // Packed by blocks that their sides are no multiples of, and closely.
    const std::vector<PatchShape> shapes = log_normal_shapes(600, 130, 0.15);
    expect_valid(shapes, pack(shapes, {.page_size = 4096, .packer = Packer::kBitmap}));
}

TEST(PackBitmap, FillsAPageThatHoldsThemExactly) {
    const std::vector<PatchShape> shapes(16, rectangle(32, 16));
    EXPECT_TRUE(pack_into(shapes, std::vector{PageSize{128, 64}}, kBitmap));
    EXPECT_FALSE(pack_into(shapes, std::vector{PageSize{128, 63}}, kBitmap));
}

TEST(Pack, PutsLikeShapesSideBySide) {
    // As a viewer's mip levels see it: the spread of colour within cells of 32 texels.
    std::vector<PatchShape> shapes = log_normal_shapes(4000, 12, 0.4);
    const auto spread = [](const std::vector<PatchShape>& of, const Packing& packing) {
        std::map<std::array<int, 3>, std::array<double, 3>> cells;
        for (std::size_t i = 0; i < of.size(); ++i) {
            const Placement& at = packing.placements[i];
            auto& [n, sum, squares] = cells[{static_cast<int>(at.page), at.x / 32, at.y / 32}];
            const double v = static_cast<double>((i * 7919) % 4000) / 4000;
            n += 1, sum += v, squares += v * v;
        }
        double inside = 0.0;
        for (const auto& [cell, c] : cells) inside += c[2] - c[1] * c[1] / c[0];
        return inside / static_cast<double>(of.size());
    };
    const Packing plain = pack(shapes);
    const double before = spread(shapes, plain);
    for (std::size_t i = 0; i < shapes.size(); ++i)
        shapes[i].color =
            Vec3f{1.0F, 1.0F, 1.0F} * (static_cast<float>((i * 7919) % 4000) / 4000.0F);
    const Packing sorted = pack(shapes);
    expect_valid(shapes, sorted);
    EXPECT_LT(spread(shapes, sorted), 0.35 * before);
    EXPECT_GT(sorted.fill(), plain.fill() - 0.04);
}

TEST(Pack, RefusesColoursThatAreNoNumbers) {
    std::vector<PatchShape> shapes{rectangle(8, 8), rectangle(8, 8)};
    EXPECT_NO_THROW(pack(shapes));
    shapes[1].color.y = std::nanf("");
    EXPECT_THROW(pack(shapes), Error);
}

TEST(Pack, OfNothingIsNothing) {
    const Packing packing = pack({});
    EXPECT_TRUE(packing.pages.empty());
    EXPECT_EQ(packing.fill(), 0.0);
}

TEST(Pack, FillsTheBenchmarkSets) {
    const auto shapes = log_normal_shapes(10'000, 12, 0.4);
    EXPECT_GT(pack(shapes).fill(), 0.92);
    EXPECT_GT(fill_of_paper(shapes), 0.88);
    const auto large = log_normal_shapes(4'000, 28, 0.5);
    EXPECT_GT(pack(large).fill(), 0.91);
    EXPECT_GT(fill_of_paper(large), 0.85);
}

// Share of the lowest page of a width that holds all shapes: not blurred by steps of 64 texels.
double tightest_fill(const std::vector<PatchShape>& shapes, int width) {
    std::int64_t needed = 0;
    for (const PatchShape& shape : shapes) needed += shape.num_texels();
    int low = static_cast<int>(needed / width), high = 2 * low + 400;
    while (high - low > 1) {
        const int middle = (low + high) / 2;
        (pack_into(shapes, std::vector{PageSize{width, middle}}) ? high : low) = middle;
    }
    expect_valid(shapes, *pack_into(shapes, std::vector{PageSize{width, high}}));
    return static_cast<double>(needed) / width / high;
}

TEST(Pack, FillsSetsOfEqualShapes) {
    EXPECT_GT(tightest_fill(repeated(1500, triangle_shape(12, 8, 5)), 384), 0.87);
    EXPECT_GT(tightest_fill(repeated(1500, triangle_shape(2, 1, 1)), 96), 0.99);
}

TEST(Pack, FillsSetsOfTwoSizes) {
    auto two = repeated(1500, triangle_shape(10, 6, 3));
    for (int i = 0; i < 150; ++i) two.push_back(triangle_shape(44, 30, 4 + i % 36));
    EXPECT_GT(tightest_fill(two, 448), 0.88);
    auto huge = repeated(1500, triangle_shape(6, 4, 2));
    huge.push_back(triangle_shape(300, 250, 100));
    EXPECT_GT(tightest_fill(huge, 320), 0.86);
}

TEST(Pack, FillsSetsOfNeedles) {
    std::vector<PatchShape> needles;
    for (int i = 0; i < 1500; ++i)
        needles.push_back(triangle_shape(30 + i % 40, 1 + i % 4, 3 + i % 25));
    for (int i = 0; i < 500; ++i) needles.push_back(triangle_shape(1 + i % 3, 20 + i % 20, i % 2));
    EXPECT_GT(tightest_fill(needles, 512), 0.88);
}

TEST(Pack, PutsTheSmallestShapesIntoGaps) {
    // alone, the large ones leave more than 4000 texels between them
    auto shapes = log_normal_shapes(500, 30, 0.3);
    const double large = tightest_fill(shapes, 384);
    const auto ones = repeated(4000, need_set({}).shape);
    shapes.insert(shapes.end(), ones.begin(), ones.end());
    EXPECT_GT(tightest_fill(shapes, 384), large + 0.015);
}

TEST(Pack, OpensPagesAsNeeded) {
    const auto shapes = log_normal_shapes(3000, 14, 0.4);
    const AtlasOptions options{.page_size = 256};
    const Packing packing = pack(shapes, options);
    expect_valid(shapes, packing);
    expect_sides(packing, options);
    EXPECT_GE(packing.pages.size(), 5U);
    EXPECT_GT(packing.fill(), 0.85);
}

TEST(Pack, DoesNotDependOnTheOrderOfShapes) {
    const auto shapes = log_normal_shapes(2000, 9, 0.6);
    std::vector<std::size_t> order(shapes.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(),
              [](std::size_t a, std::size_t b) { return hash64(9, a) < hash64(9, b); });
    std::vector<PatchShape> shuffled;
    for (const std::size_t i : order) shuffled.push_back(shapes[i]);
    for (const Packer packer : {Packer::kLeastWaste, Packer::kAppendixA}) {
        const Packing a = pack(shapes, {.packer = packer}), b = pack(shuffled, {.packer = packer});
        EXPECT_EQ(a.num_texels, b.num_texels);
        // the same places, taken by the same kinds of shape
        std::vector<std::array<int, 4>> places_a, places_b;
        for (std::size_t i = 0; i < shapes.size(); ++i) {
            places_a.push_back(
                {a.placements[i].x, a.placements[i].y, shapes[i].width(), shapes[i].height()});
            places_b.push_back(
                {b.placements[i].x, b.placements[i].y, shuffled[i].width(), shuffled[i].height()});
        }
        std::sort(places_a.begin(), places_a.end());
        std::sort(places_b.begin(), places_b.end());
        EXPECT_EQ(places_a, places_b);
    }
}

TEST(Pack, IsTheSameForAnyNumberOfThreads) {
    const auto shapes = log_normal_shapes(1000, 12, 0.5);
    Context one, seven;
    one.threads = 1;
    seven.threads = 7;
    const Packing a = pack(shapes, {}, one), b = pack(shapes, {}, seven);
    for (std::size_t i = 0; i < shapes.size(); ++i) {
        EXPECT_EQ(a.placements[i].x, b.placements[i].x);
        EXPECT_EQ(a.placements[i].y, b.placements[i].y);
        EXPECT_EQ(a.placements[i].mirror_x, b.placements[i].mirror_x);
        EXPECT_EQ(a.placements[i].mirror_y, b.placements[i].mirror_y);
    }
}

TEST(Pack, RefusesWhatDoesNotFitAPage) {
    for (const Packer packer : {Packer::kLeastWaste, Packer::kAppendixA}) {
        const AtlasOptions options{.page_size = 100, .packer = packer};
        for (const PatchShape& shape :
             {triangle_shape(64, 3, 2), triangle_shape(3, 64, 2), triangle_shape(500, 300, 100)}) {
            try {
                pack(std::vector{triangle_shape(4, 3, 2), shape}, options);
                FAIL() << "packed";
            } catch (const Error& e) {
                EXPECT_EQ(e.code(), ErrorCode::kLimit);
                EXPECT_NE(std::string(e.what()).find("patch 1"), std::string::npos) << e.what();
            }
        }
        // the largest that does
        const Packing packing = pack(std::vector{triangle_shape(63, 63, 30)}, options);
        EXPECT_EQ(packing.pages.size(), 1U);
    }
}

TEST(Pack, RefusesShapesThatAreNone) {
    EXPECT_THROW(pack(std::vector{PatchShape{}}), Error);
    EXPECT_THROW(pack(std::vector{PatchShape{{{0, 3}, {2, 1}}}}), Error);
    EXPECT_THROW(pack(std::vector{PatchShape{{{1, 3}, {2, 4}}}}), Error);
    EXPECT_THROW(pack(std::vector{PatchShape{{{-1, 3}}}}), Error);
}

TEST(Pack, RefusesPagesThatNoGpuTakes) {
    const std::vector shapes{triangle_shape(4, 3, 2)};
    for (const int size : {-1, 0, 63, 20'000})
        EXPECT_THROW(pack(shapes, {.page_size = size}), Error) << size;
}

TEST(Pack, StopsWhenTold) {
    std::stop_source source;
    source.request_stop();
    Context context;
    context.stop = source.get_token();
    const auto shapes = log_normal_shapes(100, 9, 0.6);
    EXPECT_THROW(pack(shapes, {}, context), Error);
    EXPECT_THROW(pack_into(shapes, std::vector{PageSize{1024, 1024}}, {}, context), Error);
}

TEST(PackInto, FillsGivenPagesToNineTenths) {
    const auto shapes = log_normal_shapes(10'000, 10, 0.4);
    std::int64_t needed = 0;
    for (const PatchShape& shape : shapes) needed += shape.num_texels();
    const int height = static_cast<int>(static_cast<double>(needed) / (0.925 * 1024));
    const std::vector pages{PageSize{1024, height}};
    const auto packing = pack_into(shapes, pages);
    ASSERT_TRUE(packing.has_value());
    expect_valid(shapes, *packing);
    EXPECT_GT(packing->fill(), 0.92);
}

TEST(PackInto, UsesEveryPage) {
    const auto shapes = log_normal_shapes(2000, 12, 0.5);
    std::int64_t needed = 0;
    for (const PatchShape& shape : shapes) needed += shape.num_texels();
    const int side = static_cast<int>(std::sqrt(static_cast<double>(needed) / 0.88 / 2.0));
    const std::vector pages{PageSize{side, side}, PageSize{side / 2, side},
                            PageSize{side, side / 2}};
    const auto packing = pack_into(shapes, pages);
    ASSERT_TRUE(packing.has_value());
    expect_valid(shapes, *packing);
}

TEST(PackInto, SaysSoWhenPagesAreTooSmall) {
    const auto shapes = log_normal_shapes(1000, 10, 0.4);
    EXPECT_FALSE(pack_into(shapes, std::vector{PageSize{192, 192}}).has_value());
    std::int64_t needed = 0;
    for (const PatchShape& shape : shapes) needed += shape.num_texels();
    // room for all texels, but for no packing that there is
    const int height = static_cast<int>(needed / 256 + 1);
    EXPECT_FALSE(pack_into(shapes, std::vector{PageSize{256, height}}).has_value());
    EXPECT_THROW(pack_into(shapes, std::vector{PageSize{4, 4}}), Error);
    EXPECT_THROW(pack_into(shapes, std::vector{PageSize{0, 100}}), Error);
}

TEST(PackInto, FillsAPageToTheLastTexelWhereShapesAllow) {
    const auto ones = repeated(64 * 64, need_set({}).shape);
    const auto packing = pack_into(ones, std::vector{PageSize{64, 64}});
    ASSERT_TRUE(packing.has_value());
    expect_valid(ones, *packing);
    EXPECT_EQ(packing->fill(), 1.0);
}

}  // namespace
}  // namespace pointbake
