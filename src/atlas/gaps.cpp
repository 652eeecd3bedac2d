// First fit over occupancy bitmaps, 64 positions at a time: a shape fits at x iff each of its rows
// begins at x + left a run of free texels as long as the row.
#include "atlas/gaps.h"

#include <bit>
#include <limits>

#include "core/parallel.h"

namespace pointbake {
namespace {

using Word = std::uint64_t;
constexpr int kWordBits = 64;

// Words that a search may touch, over all shapes and pages: some tenths of a second. Sets that come
// near it hardly ever fit in the end.
constexpr std::int64_t kMaxWork = 150'000'000;

class Bitmap {
 public:
    explicit Bitmap(PageSize size)
        : width_(size.width),
          height_(size.height),
          words_((size.width + kWordBits - 1) / kWordBits),
          free_(static_cast<std::size_t>(words_) * static_cast<std::size_t>(height_), 0),
          longest_run_(static_cast<std::size_t>(height_), width_) {
        for (int y = 0; y < height_; ++y) set(y, 0, width_, true);
    }

    int height() const { return height_; }
    int width() const { return width_; }
    int words() const { return words_; }
    const Word* row(int y) const { return free_.data() + at(y); }
    /// No free run of this scan line is longer.
    int longest_run(int y) const { return longest_run_[static_cast<std::size_t>(y)]; }

    void set(int y, int begin, int end, bool is_free) {
        Word* const words = free_.data() + at(y);
        for (int w = begin / kWordBits; w * kWordBits < end; ++w) {
            const int from = std::max(begin - w * kWordBits, 0);
            const int to = std::min(end - w * kWordBits, kWordBits);
            const Word mask = (~Word{0} >> (kWordBits - (to - from))) << from;
            words[w] = is_free ? words[w] | mask : words[w] & ~mask;
        }
    }
    void take(int y, int begin, int end) { set(y, begin, end, false); }

    void measure_runs() {
        for (int y = 0; y < height_; ++y) measure_runs(y);
    }

 private:
    std::size_t at(int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(words_);
    }
    void measure_runs(int y) {
        const Word* const words = row(y);
        int longest = 0, run = 0;
        for (int w = 0; w < words_; ++w) {
            if (words[w] == 0) {
                run = 0;
                continue;
            }
            for (int x = 0; x < kWordBits;) {
                const Word rest = words[w] >> x;
                const int ones = std::min(std::countr_one(rest), kWordBits - x);
                run += ones;
                longest = std::max(longest, run);
                x += ones;
                if (x >= kWordBits) break;
                run = 0;
                const Word after = words[w] >> x;
                x += after == 0 ? kWordBits - x : std::countr_zero(after);
            }
        }
        longest_run_[static_cast<std::size_t>(y)] = longest;
    }

    int width_, height_, words_;
    std::vector<Word> free_;
    std::vector<int> longest_run_;
};

// out[x] = in[x + shift], zeros beyond the end.
void shift_down(const Word* in, Word* out, int words, int shift) {
    const int whole = shift / kWordBits, part = shift % kWordBits;
    for (int w = 0; w < words; ++w) {
        const Word low = w + whole < words ? in[w + whole] : 0;
        const Word high = w + whole + 1 < words ? in[w + whole + 1] : 0;
        out[w] = part == 0 ? low : (low >> part) | (high << (kWordBits - part));
    }
}

class GapFiller {
 public:
    GapFiller(const ShapeSet& shapes, Layout& layout) : shapes_(shapes), layout_(layout) {
        for (const PageSize& size : layout.pages) bitmaps_.emplace_back(size);
        for (int rank = 0; rank < shapes.size(); ++rank)
            if (layout.spot(rank).page != kUnplaced) take(rank);
        for (Bitmap& b : bitmaps_) b.measure_runs();
    }

    bool run(const Context& context) {
        Spot start{0, 0, 0, 0};
        for (int rank = 0; rank < shapes_.size(); ++rank) {
            if (layout_.spot(rank).page != kUnplaced) continue;
            check_cancelled(context);
            // what had no room for the same shape before has none now
            if (!shapes_[rank].is_repeat) start = {0, 0, 0, 0};
            if (!search(rank, start)) return false;
            layout_.spot(rank) = start;
            take(rank);
        }
        return true;
    }

 private:
    void take(int rank) {
        const Spot& spot = layout_.spot(rank);
        const ShapeSet::Item& item = shapes_[rank];
        const std::int16_t* const left = shapes_.left_profile(rank, spot.pose);
        const std::int16_t* const right = shapes_.left_profile(rank, opposite_side(spot.pose));
        for (int j = 0; j < item.height; ++j)
            bitmaps_[static_cast<std::size_t>(spot.page)].take(spot.y + j, spot.x + left[j],
                                                               spot.x + item.width - right[j]);
    }

    // Moves `spot` to the first place at or after its page and scan line where the shape fits.
    bool search(int rank, Spot& spot) {
        const int height = shapes_[rank].height;
        for (; spot.page < static_cast<int>(bitmaps_.size()); ++spot.page, spot.y = 0) {
            const Bitmap& page = bitmaps_[static_cast<std::size_t>(spot.page)];
            for (; spot.y + height <= page.height(); ++spot.y) {
                if (work_ > kMaxWork) return false;
                for (spot.pose = 0; spot.pose < kNumPoses; ++spot.pose)
                    if (fits(page, rank, spot)) return true;
            }
        }
        return false;
    }

    // Looks for the first x of a scan line.
    bool fits(const Bitmap& page, int rank, Spot& spot) {
        const ShapeSet::Item& item = shapes_[rank];
        const std::int16_t* const left = shapes_.left_profile(rank, spot.pose);
        const std::int16_t* const right = shapes_.left_profile(rank, opposite_side(spot.pose));
        ++work_;
        for (int j = 0; j < item.height; ++j)
            if (page.longest_run(spot.y + j) < item.width - right[j] - left[j]) return false;
        const int words = page.words();
        found_.assign(static_cast<std::size_t>(words), ~Word{0});
        for (int j = 0; j < item.height; ++j) {
            if (!keep_starts(page.row(spot.y + j), words, left[j], item.width - right[j] - left[j]))
                return false;
        }
        for (int w = 0; w < words; ++w) {
            if (found_[static_cast<std::size_t>(w)] == 0) continue;
            spot.x = w * kWordBits + std::countr_zero(found_[static_cast<std::size_t>(w)]);
            return true;
        }
        return false;
    }

    // Clears the positions x of found_ where [x + left, x + left + length) is not free; false if
    // none is left.
    bool keep_starts(const Word* free, int words, int left, int length) {
        const auto n = static_cast<std::size_t>(words);
        runs_.assign(free, free + words);
        shifted_.resize(n);
        // runs of 2^k texels from runs of 2^(k-1)
        for (int run = 1; run < length;) {
            const int step = std::min(run, length - run);
            shift_down(runs_.data(), shifted_.data(), words, step);
            for (std::size_t w = 0; w < n; ++w) runs_[w] &= shifted_[w];
            run += step;
            work_ += words;
        }
        shift_down(runs_.data(), shifted_.data(), words, left);
        Word any = 0;
        for (std::size_t w = 0; w < n; ++w) any |= found_[w] &= shifted_[w];
        work_ += words;
        return any != 0;
    }

    const ShapeSet& shapes_;
    Layout& layout_;
    std::vector<Bitmap> bitmaps_;
    std::vector<Word> found_, runs_, shifted_;
    std::int64_t work_ = 0;
};

}  // namespace

bool fill_gaps(const ShapeSet& shapes, Layout& layout, const Context& context) {
    return GapFiller(shapes, layout).run(context);
}

}  // namespace pointbake
