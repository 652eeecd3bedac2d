// Based on [Wicke05, Appendix A]; letters as there. Departures, where the pseudo-code does not
// terminate or overlaps: inserted triangles leave T and T_h; T_h is formed anew when it is empty
// and the row goes on (closing it halves the fill); y_min advances by the height of the row, not by
// the current h; what is wider than a page is refused before.
#include "atlas/appendix_a.h"

#include <cmath>

#include "atlas/match_index.h"
#include "core/parallel.h"

namespace pointbake {
namespace {

// Delta h. The paper gives no value; below 3 the fill hardly depends on it, above it falls.
constexpr int kDeltaHeight = 2;

constexpr double kQuarterPi = 0.78539816339744831;
constexpr double kHalfPi = 2.0 * kQuarterPi;

// Within 0.004 rad: libm's differs between machines.
double arctan(double t) {
    if (t > 1.0) return kHalfPi - arctan(1.0 / t);
    if (t < 0.0) return -arctan(-t);
    return t * (kQuarterPi + 0.273 * (1.0 - t));
}

// Angle between the base and the left side of a profile whose base is its first or last row.
double base_angle(const std::int16_t* left, int height, bool base_is_last) {
    const int at_base = left[base_is_last ? height - 1 : 0];
    const int at_apex = left[base_is_last ? 0 : height - 1];
    return kHalfPi - arctan(static_cast<double>(at_apex - at_base) / height);
}

class AppendixA {
 public:
    AppendixA(const ShapeSet& shapes, Layout& layout)
        : shapes_(shapes), layout_(layout), index_(shapes, 2, [this](int rank, int pose) {
              return base_angle(shapes_.left_profile(rank, pose), shapes_[rank].height,
                                base_is_last(rank));
          }) {}

    bool run(const Context& context) {
        while (skip_empty_classes()) {
            check_cancelled(context);
            std::optional<Row> row = new_row(index_.classes()[tallest_].height, layout_);
            if (!row) return false;
            fill(*row);
        }
        return true;
    }

 private:
    int row_length(int rank, int j) const {
        const ShapeSet::Item& item = shapes_[rank];
        return item.width - shapes_.left_profile(rank, 0)[j] - shapes_.left_profile(rank, 1)[j];
    }
    bool base_is_last(int rank) const {
        return row_length(rank, shapes_[rank].height - 1) >= row_length(rank, 0);
    }

    bool skip_empty_classes() {
        const auto& classes = index_.classes();
        while (tallest_ < classes.size() && classes[tallest_].num_left == 0) ++tallest_;
        return tallest_ < classes.size();
    }

    void fill(Row& row) {
        double beta = kHalfPi;
        for (bool mirror_h = false; skip_empty_classes(); mirror_h = !mirror_h) {
            const auto [entry, class_index] = best_match(beta);
            const int rank = entry.rank;
            if (!insert(row, entry, mirror_h)) return;
            beta = base_angle(shapes_.left_profile(rank, opposite_side(entry.pose)),
                              shapes_[rank].height, base_is_last(rank));
            index_.remove(class_index, rank);
        }
    }

    // The triangle of T_h, and its side, whose angle is closest to beta.
    std::pair<MatchIndex::Entry, std::size_t> best_match(double beta) {
        std::pair<MatchIndex::Entry, std::size_t> best{};
        double smallest = HUGE_VAL;
        const auto& classes = index_.classes();
        const int h = classes[tallest_].height;
        for (std::size_t c = tallest_; c < classes.size() && classes[c].height > h - kDeltaHeight;
             ++c) {
            const MatchIndex::Entry* const e = MatchIndex::Walk(index_, classes[c], beta).next();
            if (e == nullptr || std::fabs(e->key - beta) >= smallest) continue;
            smallest = std::fabs(e->key - beta);
            best = {*e, c};
        }
        return best;
    }

    // Upright triangles stand on the row's last scan line, turned ones hang from its first.
    bool insert(Row& row, const MatchIndex::Entry& entry, bool mirror_h) {
        const ShapeSet::Item& item = shapes_[entry.rank];
        const int pose = entry.pose | (base_is_last(entry.rank) == mirror_h ? 2 : 0);
        const int offset = mirror_h ? 0 : row.height - item.height;
        const std::int16_t* const left = shapes_.left_profile(entry.rank, pose);
        int x = 0;
        for (int j = 0; j < item.height; ++j)
            x = std::max(x, row.edge[static_cast<std::size_t>(offset + j)] - left[j]);
        if (x + item.width > row.limit) return false;
        put(shapes_, entry.rank, pose, x, offset, row, layout_);
        return true;
    }

    const ShapeSet& shapes_;
    Layout& layout_;
    MatchIndex index_;
    std::size_t tallest_ = 0;
};

}  // namespace

bool pack_appendix_a(const ShapeSet& shapes, Layout& layout, const Context& context) {
    return AppendixA(shapes, layout).run(context);
}

}  // namespace pointbake
