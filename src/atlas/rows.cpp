// Based on the packing of [Wicke05, Appendix A] after [Hale98]: rows of triangles of like height,
// each matched to its predecessor's side. Departures: the edge of a row is kept per scan line, so
// shapes of any kind are packed and short ones do not hide long ones; the match is the free area
// enclosed, not a difference of angles; all four mirror poses; what a row leaves over (the steps
// beside its shorter shapes, its end) is filled by later, smaller ones.
#include "atlas/rows.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "atlas/gaps.h"
#include "atlas/match_index.h"
#include "core/parallel.h"

namespace pointbake {
namespace {

// Weight of the texels above a shape that is lower than its row, against those wasted beside it:
// they are narrow and hold but small shapes, and a row that is not used up to its height costs its
// width.
constexpr double kHeightLoss = 3.0;

// Weight of the texels of a shape of another colour than belongs there (Tints::distance). Rows that
// all run through the colours from left to right have like ones beside, above and below each shape,
// so that mip levels mix like ones; it costs one and a half percent of fill.
constexpr double kTintLoss = 0.2;

// A row runs through the tints of the shapes that so many rows like it will hold: colours of small
// triangles are often not those of large ones.
constexpr int kRowsOfTints = 2;
constexpr std::size_t kMostOfTints = 2048;  // shapes that tell them

// Shapes lower than this share of the row's height wait for a row of their own, often in what this
// one leaves over.
constexpr double kLowestShare = 0.6;

// Candidates tried per shape placed, those of like lean first. Without colours 200 fill as well;
// with them more find like ones.
constexpr int kTrials = 200, kTrialsWithColors = 400;

// At least this many of a lower height class, when the taller one has few left.
constexpr int kTrialsPerClass = 30;

// Times as many candidates are tried for one place when few fit.
constexpr int kPatience = 4;

// A leftover is worth a row of its own if it is this many times as wide as a typical shape; as long
// as there are untouched scan lines.
constexpr int kWorthShapes = 3;

// Steps of a leftover's edge that are kept apart, in texels.
constexpr int kStep = 6;

// Gaps before a shape of at least so many texels are kept, in at most kBands bands.
constexpr int kWorthGap = 64;
constexpr int kBands = 8;

// Narrower leftovers are not kept: shapes small enough for them find them one by one.
constexpr int kNarrowest = 3;

// Sum of (2 j - (h - 1)) edge[j]: the slope of a least-squares line through an edge, times a
// constant of the height. Where a row's edge and a shape's side lean alike, little is wasted
// between them (for triangles it is cot alpha - cot beta that counts).
double lean(const std::int16_t* edge, int height) {
    std::int64_t sum = 0;
    for (int j = 0; j < height; ++j) sum += std::int64_t{2 * j - (height - 1)} * edge[j];
    return static_cast<double>(sum);
}

std::int64_t sum_of(const std::int16_t* edge, int height) {
    return std::accumulate(edge, edge + height, std::int64_t{0});
}

// Leftovers are searched one by one: beyond this many, the smaller half is given up.
constexpr std::size_t kMaxLeftovers = 4096;

// A part of a row that shapes have left free; lower shapes may still lie at its far end, where the
// edge is often farther left.
struct Leftover {
    Row row;
    std::vector<std::int16_t> start;  // start[k]: rightmost edge of the last k scan lines
    std::int64_t area = 0;

    explicit Leftover(Row r) : row(std::move(r)) { measure(); }
    void measure() {
        area = std::int64_t{row.height} * row.limit - sum_of(row.edge.data(), row.height);
        start.assign(static_cast<std::size_t>(row.height) + 1, 0);
        for (std::size_t k = 1; k < start.size(); ++k)
            start[k] = std::max(start[k - 1], row.edge[static_cast<std::size_t>(row.height) - k]);
    }
    /// Free width over the last `height` scan lines.
    int width(int height) const { return row.limit - start[static_cast<std::size_t>(height)]; }
};

// Scan lines [begin, begin + height) of a row.
Row slice(const Row& row, int begin, int height, int limit) {
    Row out(row.page, row.y + begin, height, limit);
    std::copy_n(row.edge.begin() + begin, height, out.edge.begin());
    return out;
}

class RowPacker {
 public:
    RowPacker(const ShapeSet& shapes, Layout& layout)
        : shapes_(shapes),
          layout_(layout),
          trials_(shapes.tints().are_one() ? kTrials : kTrialsWithColors),
          index_(shapes, kNumPoses, [&](int rank, int pose) {
              return lean(shapes.left_profile(rank, pose), shapes[rank].height);
          }) {
        for (int rank = 0; rank < shapes.size(); ++rank)
            for (int pose = 0; pose < 2; ++pose)
                profile_sums_.push_back(
                    sum_of(shapes.left_profile(rank, pose), shapes[rank].height));
        for (const MatchIndex::HeightClass& c : index_.classes())
            narrowest_.push_back(c.last_rank - 1);
    }

    bool run(const Context& context) {
        while (tallest_ < index_.classes().size()) {
            check_cancelled(context);
            if (tallest().num_left == 0) {
                ++tallest_;
                continue;
            }
            const int h = tallest().height;
            std::optional<Row> row = take_leftover(h, kWorthShapes * median_width());
            if (!row) {
                row = new_row(h, layout_);
                if (row) find_tints(*row);
            }
            const bool is_last_resort = !row;
            if (!row) row = take_leftover(h, narrowest_width());
            if (row) {
                const bool has_filled = fill(*row, is_last_resort);
                keep_leftover(*row);
                if (has_filled) continue;
            }
            if (!fill_gaps(context)) return false;
        }
        return true;
    }

 private:
    struct Candidate {
        std::size_t class_index = 0;
        int rank = kUnplaced, pose = 0, x = 0;
        std::int64_t waste = 0;
        double score = std::numeric_limits<double>::infinity();
    };

    const MatchIndex::HeightClass& tallest() const { return index_.classes()[tallest_]; }
    // Ranks of a class are sorted by width.
    int median_width() const {
        return shapes_[(tallest().first_rank + tallest().last_rank) / 2].width;
    }
    int narrowest_width() {
        int& rank = narrowest_[tallest_];
        while (!index_.is_left(rank)) --rank;
        return shapes_[rank].width;
    }

    // Those of shapes that are left, evenly chosen among the tallest ones, so many that a few rows
    // like this one would hold them.
    void find_tints(const Row& row) {
        if (shapes_.tints().are_one()) return;
        const auto& classes = index_.classes();
        const std::int64_t enough = std::int64_t{kRowsOfTints} * row.height * row.limit;
        std::int64_t area = 0;
        std::vector<int> left;
        for (std::size_t c = tallest_; c < classes.size() && area < enough; ++c)
            for (int rank = classes[c].first_rank; rank < classes[c].last_rank; ++rank)
                if (index_.is_left(rank)) left.push_back(rank), area += shapes_[rank].num_texels;
        const std::size_t step = 1 + left.size() / kMostOfTints;
        std::vector<Index> chosen;
        for (std::size_t i = 0; i < left.size(); i += step)
            chosen.push_back(shapes_[left[i]].shape);
        tints_ = shapes_.tints().row_of(std::move(chosen));
    }

    // Fills a row from left to right. False if nothing fits.
    bool fill(Row& row, bool is_last_resort) {
        Candidate c = best(row);
        if (c.rank == kUnplaced && is_last_resort) c = widest_that_fits(row);
        const bool has_placed = c.rank != kUnplaced;
        for (; c.rank != kUnplaced; c = best(row)) {
            if (c.waste >= kWorthGap) keep_gap(row, c);
            put(shapes_, c.rank, c.pose, c.x, 0, row, layout_);
            index_.remove(c.class_index, c.rank);
            if (gaps_) gaps_->take(c.rank);
        }
        return has_placed;
    }

    Candidate best(const Row& row) {
        Candidate best;
        int num_tried = 0;
        const auto& classes = index_.classes();
        const double lowest = row.height * kLowestShare;
        for (std::size_t c = tallest_; c < classes.size() && classes[c].height >= lowest; ++c) {
            if (classes[c].num_left == 0) continue;
            const MatchIndex::HeightClass& like = classes[c];
            const int trials = std::max(trials_ - num_tried, kTrialsPerClass);
            MatchIndex::Walk walk(index_, like, lean(row.edge.data(), like.height));
            const std::int64_t edge_sum = sum_of(row.edge.data(), like.height);
            for (int n = 0; n < trials; ++n, ++num_tried) {
                const MatchIndex::Entry* const e = walk.next();
                if (e == nullptr) break;
                try_shape(row, edge_sum, c, e->rank, e->pose, best);
            }
            if (num_tried >= (best.rank == kUnplaced ? kPatience * trials_ : trials_)) break;
        }
        return best;
    }

    // Of the tallest class: narrow shapes may be too far away by lean for best().
    Candidate widest_that_fits(const Row& row) {
        Candidate best;
        const std::int64_t edge_sum = sum_of(row.edge.data(), row.height);
        int rank = tallest().first_rank;
        const int width = row.limit - *std::max_element(row.edge.begin(), row.edge.end());
        while (rank < tallest().last_rank && (shapes_[rank].width > width || !index_.is_left(rank)))
            ++rank;
        for (int pose = 0; pose < kNumPoses && rank < tallest().last_rank; ++pose)
            try_shape(row, edge_sum, tallest_, rank, pose, best);
        return best;
    }

    void try_shape(const Row& row, std::int64_t edge_sum, std::size_t class_index, int rank,
                   int pose, Candidate& best) const {
        const int height = index_.classes()[class_index].height;
        const int width = shapes_[rank].width;
        const int x =
            leftmost(row.edge.data(), shapes_.left_profile(rank, pose), num_blocks(height));
        if (x + width > row.limit) return;
        const std::int64_t waste = std::int64_t{height} * x + profile_sum(rank, pose) - edge_sum;
        const PageSize& page = layout_.pages[static_cast<std::size_t>(row.page)];
        const double off_tint =
            shapes_.tints().distance(shapes_[rank].shape, tints_, (x + 0.5 * width) / page.width);
        const double score = static_cast<double>(waste) +
                             kHeightLoss * (row.height - height) * width +
                             kTintLoss * off_tint * shapes_[rank].num_texels;
        if (score < best.score) best = {class_index, rank, pose, x, waste, score};
    }

    // Mirroring in y does not change the sum.
    std::int64_t profile_sum(int rank, int pose) const {
        return profile_sums_[static_cast<std::size_t>(2 * rank + (is_mirrored_x(pose) ? 1 : 0))];
    }

    void keep_leftover(const Row& row) {
        int full = 0;
        while (full < row.height &&
               row.limit - row.edge[static_cast<std::size_t>(full)] < kNarrowest)
            ++full;
        if (full == row.height) return;
        leftovers_.emplace_back(slice(row, full, row.height - full, row.limit));
        if (leftovers_.size() <= kMaxLeftovers) return;
        std::sort(leftovers_.begin(), leftovers_.end(), [](const Leftover& a, const Leftover& b) {
            if (a.area != b.area) return a.area > b.area;
            if (a.row.page != b.row.page) return a.row.page < b.row.page;
            return a.row.y != b.row.y ? a.row.y < b.row.y : a.row.limit < b.row.limit;
        });
        leftovers_.erase(leftovers_.begin() + kMaxLeftovers / 2, leftovers_.end());
    }

    // Keeps what a shape to be placed will shut off from the row, in bands that end straight.
    void keep_gap(const Row& row, const Candidate& c) {
        const int height = shapes_[c.rank].height;
        const std::int16_t* const left = shapes_.left_profile(c.rank, c.pose);
        const int band = std::max(kBlock, height / kBands);
        for (int j = 0; j < height; j += band) {
            const int end = std::min(j + band, height);
            keep_leftover(slice(row, j, end - j, c.x + *std::min_element(left + j, left + end)));
        }
    }

    // Places the rest of the tallest class one by one; false as soon as one does not fit.
    bool fill_gaps(const Context& context) {
        if (!gaps_) start_gaps();
        for (int rank = tallest().first_rank; rank < tallest().last_rank; ++rank) {
            if (!index_.is_left(rank)) continue;
            check_cancelled(context);
            if (!gaps_->place(rank)) return false;
            index_.remove(tallest_, rank);
            shut_off(rank);
        }
        return true;
    }

    // From now on shapes lie anywhere, so the lower ends of pages become leftovers too.
    void start_gaps() {
        gaps_.emplace(shapes_, layout_);
        for (std::size_t p = 0; p < layout_.pages.size(); ++p) {
            const PageSize page = layout_.pages[p];
            int& used = layout_.used_height[p];
            if (used < page.height)
                keep_leftover(Row(static_cast<int>(p), used, page.height - used, page.width));
            used = page.height;
        }
    }

    // Moves the edges of leftovers behind a shape that lies in them.
    void shut_off(int rank) {
        const Spot& spot = layout_.spot(rank);
        const int height = shapes_[rank].height, end = spot.x + shapes_[rank].width;
        for (Leftover& l : leftovers_) {
            Row& row = l.row;
            const int first = std::max(row.y, spot.y);
            const int last = std::min(row.y + row.height, spot.y + height);
            if (row.page != spot.page || first >= last || spot.x >= row.limit) continue;
            bool has_moved = false;
            for (int y = first; y < last; ++y) {
                std::int16_t& edge = row.edge[static_cast<std::size_t>(y - row.y)];
                if (edge >= end) continue;
                edge = static_cast<std::int16_t>(std::min(end, row.limit));
                has_moved = true;
            }
            if (has_moved) l.measure();
        }
    }

    // The lowest leftover that has room for shapes of a height and width.
    std::size_t find_leftover(int height, int width) const {
        std::size_t best = leftovers_.size();
        for (std::size_t i = 0; i < leftovers_.size(); ++i) {
            const Leftover& l = leftovers_[i];
            if (l.row.height < height || l.width(height) < width) continue;
            if (best == leftovers_.size() || l.row.height < leftovers_[best].row.height ||
                (l.row.height == leftovers_[best].row.height &&
                 l.width(height) > leftovers_[best].width(height)))
                best = i;
        }
        return best;
    }

    // Cuts a row of the given height from the far end of a leftover; what remains of it is kept.
    std::optional<Row> take_leftover(int height, int width) {
        const std::size_t found = find_leftover(height, width);
        if (found == leftovers_.size()) return std::nullopt;
        const Leftover from = std::move(leftovers_[found]);
        leftovers_[found] = std::move(leftovers_.back());
        leftovers_.pop_back();
        const int before = from.row.height - height;
        const int start = from.start[static_cast<std::size_t>(height)];
        Row row = slice(from.row, before, height, from.row.limit);
        const auto end = row.edge.begin() + height;
        if (start - *std::min_element(row.edge.begin(), end) > kStep) {
            keep_leftover(slice(from.row, before, height, start));
            std::fill(row.edge.begin(), end, static_cast<std::int16_t>(start));
        }
        if (before > 0) keep_leftover(slice(from.row, 0, before, from.row.limit));
        return row;
    }

    const ShapeSet& shapes_;
    Layout& layout_;
    int trials_;
    MatchIndex index_;
    std::vector<std::int64_t> profile_sums_;  // by rank, left and right
    std::vector<int> narrowest_;              // per class: no narrower shape is left
    std::vector<Leftover> leftovers_;
    std::optional<GapFiller> gaps_;
    std::size_t tallest_ = 0;
    Tints::Row tints_{};
};

}  // namespace

bool pack_rows(const ShapeSet& shapes, Layout& layout, const Context& context) {
    return RowPacker(shapes, layout).run(context);
}

}  // namespace pointbake
