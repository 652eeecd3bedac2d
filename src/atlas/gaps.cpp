// First fit over occupancy bitmaps, 64 positions at a time: a shape fits at x iff each of its rows
// begins at x + left a run of free texels as long as the row.
#include "atlas/gaps.h"

#include <algorithm>
#include <bit>

namespace pointbake {
namespace {

using Word = FreeTexels::Word;
constexpr int kWordBits = FreeTexels::kWordBits;

// Words that searches may touch: a tenth of a second. Sets that come near it hardly ever fit.
constexpr std::int64_t kMaxWork = 100'000'000;

int longest_run_of(const Word* words, int count) {
    int longest = 0, run = 0;
    for (int w = 0; w < count; ++w) {
        for (int x = 0; x < kWordBits;) {
            const int ones = std::min(std::countr_one(words[w] >> x), kWordBits - x);
            run += ones;
            longest = std::max(longest, run);
            x += ones;
            if (x == kWordBits) break;
            run = 0;
            x = std::min(x + std::countr_zero(words[w] >> x), kWordBits);
        }
    }
    return longest;
}

// out[x] = in[x + shift], zeros beyond the end.
void shift_down(const Word* in, Word* out, int words, int shift) {
    const int whole = shift / kWordBits, part = shift % kWordBits;
    for (int w = 0; w < words; ++w) {
        const Word low = w + whole < words ? in[w + whole] : 0;
        const Word high = w + whole + 1 < words ? in[w + whole + 1] : 0;
        out[w] = part == 0 ? low : (low >> part) | (high << (kWordBits - part));
    }
}

// Bits [begin, end) of a word, 0 <= begin < end <= 64.
Word bits(int begin, int end) { return (~Word{0} >> (kWordBits - (end - begin))) << begin; }

}  // namespace

FreeTexels::FreeTexels(PageSize size)
    : width_(size.width),
      height_(size.height),
      words_((size.width + kWordBits - 1) / kWordBits),
      free_(static_cast<std::size_t>(words_) * static_cast<std::size_t>(height_), ~Word{0}),
      longest_run_(static_cast<std::size_t>(height_), size.width) {
    if (width_ % kWordBits == 0) return;
    for (int y = 0; y < height_; ++y)
        free_[at(y) + static_cast<std::size_t>(words_ - 1)] = bits(0, width_ % kWordBits);
}

void FreeTexels::take(int y, int begin, int end) {
    Word* const words = free_.data() + at(y);
    for (int w = begin / kWordBits; w * kWordBits < end; ++w)
        words[w] &=
            ~bits(std::max(begin - w * kWordBits, 0), std::min(end - w * kWordBits, kWordBits));
}

void FreeTexels::measure_runs() {
    for (int y = 0; y < height_; ++y)
        longest_run_[static_cast<std::size_t>(y)] = longest_run_of(row(y), words_);
}

GapFiller::GapFiller(const ShapeSet& shapes, Layout& layout) : shapes_(shapes), layout_(layout) {
    for (const PageSize& size : layout.pages) pages_.emplace_back(size);
    for (int rank = 0; rank < shapes.size(); ++rank)
        if (layout.spot(rank).page != kUnplaced) take(rank);
    for (FreeTexels& page : pages_) page.measure_runs();
}

void GapFiller::take(int rank) {
    const Spot& spot = layout_.spot(rank);
    const ShapeSet::Item& item = shapes_[rank];
    const std::int16_t* const left = shapes_.left_profile(rank, spot.pose);
    const std::int16_t* const right = shapes_.left_profile(rank, opposite_side(spot.pose));
    for (int j = 0; j < item.height; ++j)
        pages_[static_cast<std::size_t>(spot.page)].take(spot.y + j, spot.x + left[j],
                                                         spot.x + item.width - right[j]);
}

bool GapFiller::place(int rank) {
    // what had no room for the same shape before has none now
    if (shapes_[rank].group != last_group_) last_spot_ = {0, 0, 0, 0};
    last_group_ = shapes_[rank].group;
    if (!search(rank, last_spot_)) return false;
    layout_.spot(rank) = last_spot_;
    take(rank);
    return true;
}

// Moves `spot` to the first place at or after its page and scan line where the shape fits.
bool GapFiller::search(int rank, Spot& spot) {
    const int height = shapes_[rank].height;
    for (; spot.page < static_cast<int>(pages_.size()); ++spot.page, spot.y = 0) {
        const FreeTexels& page = pages_[static_cast<std::size_t>(spot.page)];
        for (; spot.y + height <= page.height(); ++spot.y) {
            if (work_ > kMaxWork) return false;
            for (spot.pose = 0; spot.pose < kNumPoses; ++spot.pose)
                if (fits(page, rank, spot)) return true;
        }
    }
    return false;
}

// Looks for the first x of a scan line.
bool GapFiller::fits(const FreeTexels& page, int rank, Spot& spot) {
    const ShapeSet::Item& item = shapes_[rank];
    const std::int16_t* const left = shapes_.left_profile(rank, spot.pose);
    const std::int16_t* const right = shapes_.left_profile(rank, opposite_side(spot.pose));
    const auto length = [&](int j) { return item.width - right[j] - left[j]; };
    ++work_;
    for (int j = 0; j < item.height; ++j)
        if (page.longest_run(spot.y + j) < length(j)) return false;
    const int words = page.words();
    found_.assign(static_cast<std::size_t>(words), ~Word{0});
    // from both ends: one of them is the longest row, which fits least often
    for (int k = 0; k < item.height; ++k) {
        const int j = k % 2 == 0 ? item.height - 1 - k / 2 : k / 2;
        if (!keep_starts(page.row(spot.y + j), words, left[j], length(j))) return false;
    }
    for (int w = 0;; ++w) {
        const Word found = found_[static_cast<std::size_t>(w)];
        if (found == 0) continue;
        spot.x = w * kWordBits + std::countr_zero(found);
        return true;
    }
}

// Clears the positions x of found_ where [x + left, x + left + length) is not free; false if none
// is left.
bool GapFiller::keep_starts(const Word* free, int words, int left, int length) {
    const auto n = static_cast<std::size_t>(words);
    runs_.assign(free, free + words);
    shifted_.resize(n);
    // longer runs from shorter ones, doubling
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

}  // namespace pointbake
