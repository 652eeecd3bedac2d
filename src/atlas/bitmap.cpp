#include "atlas/bitmap.h"

#include <algorithm>
#include <array>
#include <bit>
#include <map>
#include <numeric>

#include "atlas/tints.h"
#include "core/parallel.h"

namespace pointbake {
namespace {

constexpr std::size_t kMostTries = 12, kMostPlacings = 2000;  // of other orders
constexpr int kRowsPerStep = 64;
using Word = std::uint64_t;
constexpr int kWordBits = 64;
constexpr int kNumPoses = 8;  // two directions, mirrored or not in both axes

// A run of texels in one row of a posed shape.
struct Run {
    int row, left, length;
};

struct Posed {
    int width = 0, height = 0;
    std::vector<Run> runs;  // by row
};

std::vector<Run> runs_of(const PatchShape& shape) {
    std::vector<Run> out;
    auto gap = shape.gaps.begin();
    for (int row = 0; row < shape.height(); ++row) {
        const PatchShape::Span span = shape.rows[static_cast<std::size_t>(row)];
        int left = span.left;
        for (; gap != shape.gaps.end() && gap->row == row; ++gap) {
            out.push_back({row, left, gap->span.left - left});
            left = gap->span.right + 1;
        }
        out.push_back({row, left, span.right + 1 - left});
    }
    return out;
}

// The blocks of texels that a shape has any of.
Posed in_blocks(const PatchShape& shape, int block) {
    Posed out{(shape.width() + block - 1) / block, (shape.height() + block - 1) / block, {}};
    std::vector<std::uint8_t> row(static_cast<std::size_t>(out.width), 0);
    const auto flush = [&](int y) {
        for (int x = 0; x < out.width; ++x) {
            if (row[static_cast<std::size_t>(x)] == 0) continue;
            const int left = x;
            while (x < out.width && row[static_cast<std::size_t>(x)] != 0) ++x;
            out.runs.push_back({y, left, x - left});
        }
        std::fill(row.begin(), row.end(), std::uint8_t{0});
    };
    int at = 0;
    for (const Run& run : runs_of(shape)) {
        if (run.row / block != at) flush(at), at = run.row / block;
        for (int x = run.left / block; x <= (run.left + run.length - 1) / block; ++x)
            row[static_cast<std::size_t>(x)] = 1;
    }
    flush(at);
    return out;
}

// Rows become columns.
Posed transposed(const Posed& from) {
    Posed out{from.height, from.width, {}};
    std::vector<std::vector<Run>> columns(static_cast<std::size_t>(from.width));
    for (const Run& run : from.runs)
        for (int x = run.left; x < run.left + run.length; ++x) {
            std::vector<Run>& column = columns[static_cast<std::size_t>(x)];
            if (!column.empty() && column.back().left + column.back().length == run.row)
                ++column.back().length;
            else
                column.push_back({x, run.row, 1});
        }
    for (const std::vector<Run>& column : columns)
        out.runs.insert(out.runs.end(), column.begin(), column.end());
    return out;
}

Posed mirrored(const Posed& from, bool x, bool y) {
    Posed out = from;
    for (Run& run : out.runs) {
        if (x) run.left = out.width - run.left - run.length;
        if (y) run.row = out.height - 1 - run.row;
    }
    return out;
}

/// Which texels of a page are free, a bit each.
class FreeBits {
 public:
    explicit FreeBits(PageSize page)
        : width_(page.width),
          height_(page.height),
          num_words_((page.width + kWordBits - 1) / kWordBits),
          bits_(static_cast<std::size_t>(num_words_) * static_cast<std::size_t>(page.height),
                ~Word{0}),
          longest_(static_cast<std::size_t>(page.height), page.width) {
        for (int y = 0; y < height_; ++y)
            for (int x = width_; x < num_words_ * kWordBits; ++x) clear(x, y);
    }

    int height() const { return height_; }
    int num_words() const { return num_words_; }

    /// The leftmost x at which the shape fits with its first row at y, or -1.
    int leftmost(const Posed& shape, int y) {
        if (shape.width > width_) return -1;
        for (const Run& run : shape.runs)
            if (longest_[static_cast<std::size_t>(y + run.row)] < run.length) return -1;
        fits_.assign(static_cast<std::size_t>(num_words_), ~Word{0});
        for (const Run& run : shape.runs) {
            const Word* row = &bits_[index(y + run.row)];
            // Where `length` free texels begin.
            erode(row, run.length);
            // The shape begins `left` texels before its run does.
            Word any = 0;
            const int words = run.left / kWordBits, bits = run.left % kWordBits;
            for (int i = 0; i < num_words_; ++i) {
                const Word low = word(i + words), high = word(i + words + 1);
                fits_[static_cast<std::size_t>(i)] &=
                    bits == 0 ? low : (low >> bits) | (high << (kWordBits - bits));
                any |= fits_[static_cast<std::size_t>(i)];
            }
            if (any == 0) return -1;
        }
        for (int i = 0; i < num_words_; ++i)
            if (const Word w = fits_[static_cast<std::size_t>(i)])
                return i * kWordBits + std::countr_zero(w);
        return -1;
    }

    void occupy(const Posed& shape, int x, int y) {
        for (const Run& run : shape.runs)
            for (int i = 0; i < run.length; ++i) clear(x + run.left + i, y + run.row);
        for (int row = y; row < y + shape.height; ++row)
            longest_[static_cast<std::size_t>(row)] = longest_run(row);
    }

 private:
    int longest_run(int y) const {
        int longest = 0, run = 0;
        for (int i = 0; i < num_words_; ++i) {
            Word w = bits_[index(y) + static_cast<std::size_t>(i)];
            for (int left = kWordBits; left > 0;) {
                const int zeros = std::min(std::countr_zero(w), left);
                if (zeros > 0) run = 0, w = zeros < kWordBits ? w >> zeros : 0, left -= zeros;
                const int ones = std::min(std::countr_one(w), left);
                run += ones, w = ones < kWordBits ? w >> ones : 0, left -= ones;
                longest = std::max(longest, run);
            }
        }
        return longest;
    }
    std::size_t index(int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(num_words_);
    }
    void clear(int x, int y) {
        bits_[index(y) + static_cast<std::size_t>(x / kWordBits)] &= ~(Word{1} << (x % kWordBits));
    }
    Word word(int i) const { return i < num_words_ ? eroded_[static_cast<std::size_t>(i)] : 0; }

    // eroded_: bit x is set iff x .. x + length - 1 are free. By doubling.
    void erode(const Word* row, int length) {
        eroded_.assign(row, row + num_words_);
        for (int have = 1; have < length;) {
            const int step = std::min(have, length - have);
            const int words = step / kWordBits, bits = step % kWordBits;
            for (int i = 0; i < num_words_; ++i) {
                const Word low = word(i + words), high = word(i + words + 1);
                eroded_[static_cast<std::size_t>(i)] &=
                    bits == 0 ? low : (low >> bits) | (high << (kWordBits - bits));
            }
            have += step;
        }
    }

    int width_, height_, num_words_;
    std::vector<Word> bits_, fits_, eroded_;
    std::vector<int> longest_;  // per row: its longest free run
};

// The longest run first, then rows far apart from each other (in the order of their reversed bits):
// that tells soonest that there is no room.
void sort_for_search(Posed& shape) {
    const auto spread = [&](const Run& run) {
        unsigned place = static_cast<unsigned>(256 * run.row / shape.height), out = 0;
        for (int bit = 0; bit < 8; ++bit, place >>= 1) out = 2 * out + (place & 1U);
        return out;
    };
    std::stable_sort(shape.runs.begin(), shape.runs.end(),
                     [&](const Run& a, const Run& b) { return spread(a) < spread(b); });
    const auto longest =
        std::max_element(shape.runs.begin(), shape.runs.end(),
                         [](const Run& a, const Run& b) { return a.length < b.length; });
    std::rotate(shape.runs.begin(), longest, longest + 1);
}

struct Found {
    int x = -1, y = 0, pose = 0;
};

/// A page, and from where on shapes of about one size still find room.
class OpenPage {
 public:
    explicit OpenPage(PageSize size) : free_(size) {}

    Found lowest_end(const std::vector<Posed>& poses) {
        Found best;
        int best_end = free_.height() + 1;
        for (int pose = 0; pose < static_cast<int>(poses.size()); ++pose) {
            const Posed& shape = poses[static_cast<std::size_t>(pose)];
            int& first = first_row_[size_class(shape)];
            // Large shapes take large steps, and the last one back by single rows.
            const int step = 1 + shape.height / kRowsPerStep;
            int y = first, x = -1;
            while (y + shape.height < best_end && (x = free_.leftmost(shape, y)) < 0) y += step;
            if (x < 0) {
                first = std::max(first, y - step);
                continue;
            }
            for (int above = y - 1; above > std::max(first, y - step); --above) {
                const int there = free_.leftmost(shape, above);
                if (there < 0) break;
                x = there, y = above;
            }
            first = std::max(first, y - step);
            best = {x, y, pose};
            best_end = y + shape.height;
        }
        return best;
    }

    void occupy(const Posed& shape, int x, int y) { free_.occupy(shape, x, y); }

 private:
    using SizeClass = std::array<int, 3>;
    // Steps of a quarter octave in height, width and the longest run.
    static SizeClass size_class(const Posed& shape) {
        const auto step = [](int size) {
            const int octave = std::bit_width(static_cast<unsigned>(size)) - 1;
            return 4 * octave + ((4 * size) >> octave) - 4;
        };
        return {step(shape.height), step(shape.width), step(shape.runs.front().length)};
    }

    FreeBits free_;
    std::map<SizeClass, int> first_row_;
};

std::vector<Posed> poses_of(const PatchShape& shape, int block) {
    const Posed upright = in_blocks(shape, block);
    const Posed turned = transposed(upright);
    std::vector<Posed> out;
    for (int pose = 0; pose < kNumPoses; ++pose)
        out.push_back(mirrored(pose & 4 ? turned : upright, pose & 1, pose & 2));
    for (Posed& posed : out) sort_for_search(posed);
    return out;
}

/// Packs in a given order; the position of the first shape that found no room, or -1.
int pack_in_order(const std::vector<std::vector<Posed>>& shapes, std::span<const Index> order,
                  std::span<const PageSize> pages, std::vector<Placement>& placements,
                  const Context& context) {
    std::vector<OpenPage> open(pages.begin(), pages.end());
    for (std::size_t rank = 0; rank < order.size(); ++rank) {
        check_cancelled(context);
        const std::vector<Posed>& poses = shapes[order[rank]];
        bool is_placed = false;
        for (Index page = 0; page < open.size() && !is_placed; ++page) {
            const Found found = open[page].lowest_end(poses);
            if (found.x < 0) continue;
            is_placed = true;
            open[page].occupy(poses[static_cast<std::size_t>(found.pose)], found.x, found.y);
            // Poses mirror after transposing, placements before.
            const bool x = found.pose & 1, y = found.pose & 2, turned = found.pose & 4;
            placements[order[rank]] = {page,           found.x,        found.y,
                                       turned ? y : x, turned ? x : y, turned};
        }
        if (!is_placed) return static_cast<int>(rank);
    }
    return -1;
}

// Large ones first; small ones, which mip levels mix first, beside those that they are like.
std::vector<Index> packing_order(std::span<const PatchShape> shapes) {
    constexpr std::int64_t kSmall = 300;  // of all texels over its own
    constexpr int kLarge = 64;
    std::int64_t total = 0;
    std::vector<std::int64_t> sizes;
    for (const PatchShape& shape : shapes) {
        sizes.push_back(shape.num_texels());
        total += sizes.back();
    }
    std::vector<int> classes;  // small ones by octaves of their side
    for (const std::int64_t size : sizes)
        classes.push_back(size * kSmall > total
                              ? kLarge
                              : static_cast<int>(std::bit_width(static_cast<std::uint64_t>(size))) /
                                    2);
    const std::vector<Index> likeness = order_by_color(shapes);
    std::vector<Index> order(shapes.size());
    std::iota(order.begin(), order.end(), Index{0});
    std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) {
        if (classes[a] != classes[b]) return classes[a] > classes[b];
        if (classes[a] == kLarge) return sizes[a] > sizes[b];
        return likeness[a] < likeness[b];
    });
    return order;
}

// Large pages of large shapes are packed by blocks of so many texels a side.
int block_size(std::span<const PatchShape> shapes, std::span<const PageSize> pages) {
    constexpr int kMostBlocks = 1024;             // per side of a page
    constexpr std::int64_t kBlocksOfAShape = 32;  // per side, in the mean
    int side = 0;
    std::int64_t texels = 0;
    for (const PageSize page : pages) side = std::max({side, page.width, page.height});
    for (const PatchShape& shape : shapes) texels += shape.num_texels();
    const auto mean = texels / static_cast<std::int64_t>(std::max<std::size_t>(shapes.size(), 1));
    int block = 1;
    while (side > kMostBlocks * block &&
           std::int64_t{4} * block * block * kBlocksOfAShape * kBlocksOfAShape <= mean)
        block *= 2;
    for (const PageSize page : pages)
        while (page.width % block != 0 || page.height % block != 0) block /= 2;
    return block;
}

// Mirrored shapes end where their last block does.
std::vector<Placement> in_texels(std::vector<Placement> placements,
                                 std::span<const PatchShape> shapes, int block) {
    for (std::size_t i = 0; i < placements.size(); ++i) {
        Placement& at = placements[i];
        const auto rest = [&](int size) { return (size + block - 1) / block * block - size; };
        const int right = at.mirror_x ? rest(shapes[i].width()) : 0,
                  lower = at.mirror_y ? rest(shapes[i].height()) : 0;
        at.x = at.x * block + (at.transposed ? lower : right);
        at.y = at.y * block + (at.transposed ? right : lower);
    }
    return placements;
}

}  // namespace

std::optional<std::vector<Placement>> pack_bitmap(std::span<const PatchShape> shapes,
                                                  std::span<const PageSize> pages,
                                                  const Context& context) {
    const int block = block_size(shapes, pages);
    std::vector<PageSize> in_blocks;
    for (const PageSize page : pages)
        in_blocks.push_back({page.width / block, page.height / block});
    std::vector<std::vector<Posed>> poses(shapes.size());
    parallel_for(context, shapes.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) poses[i] = poses_of(shapes[i], block);
    });
    std::vector<Index> order = packing_order(shapes);
    std::vector<Placement> placements(shapes.size());
    // What found no room comes first in the next try.
    const std::size_t tries =
        1 + std::min<std::size_t>(kMostTries, kMostPlacings / (1 + order.size()));
    for (std::size_t i = 0; i < tries; ++i) {
        const int failed = pack_in_order(poses, order, in_blocks, placements, context);
        if (failed < 0) return in_texels(std::move(placements), shapes, block);
        std::rotate(order.begin(), order.begin() + failed, order.begin() + failed + 1);
    }
    return std::nullopt;
}

}  // namespace pointbake
