// The last resort: single shapes into any free spot of the pages.
#pragma once

#include <vector>

#include "atlas/layout.h"

namespace pointbake {

/// One bit per texel of a page: is it free?
class FreeTexels {
 public:
    using Word = std::uint64_t;
    static constexpr int kWordBits = 64;

    explicit FreeTexels(PageSize size);

    int height() const { return height_; }
    int words() const { return words_; }  ///< per scan line
    const Word* row(int y) const { return free_.data() + at(y); }
    /// No free run of this scan line is longer.
    int longest_run(int y) const { return longest_run_[static_cast<std::size_t>(y)]; }

    void take(int y, int begin, int end);
    void measure_runs();

 private:
    std::size_t at(int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(words_);
    }

    int width_, height_, words_;
    std::vector<Word> free_;
    std::vector<int> longest_run_;
};

/// Finds the first place where a shape fits between those placed so far.
class GapFiller {
 public:
    GapFiller(const ShapeSet& shapes, Layout& layout);

    /// Says that a shape has been placed by others.
    void take(int rank);
    /// Places a shape; false if it fits nowhere, or when searching has cost as much as it may.
    bool place(int rank);

 private:
    using Word = FreeTexels::Word;
    bool search(int rank, Spot& spot);
    bool fits(const FreeTexels& page, int rank, Spot& spot);
    bool keep_starts(const Word* free, int words, int left, int length);

    const ShapeSet& shapes_;
    Layout& layout_;
    std::vector<FreeTexels> pages_;
    std::vector<Word> found_, runs_, shifted_;  // scratch
    int last_group_ = -1;
    Spot last_spot_;
    std::int64_t work_ = 0;
};

}  // namespace pointbake
