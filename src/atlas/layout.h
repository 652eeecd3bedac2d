// Where shapes lie while they are being packed.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "atlas/shape_set.h"

namespace pointbake {

inline constexpr int kUnplaced = -1;

/// Upper left corner of a shape's bounding box, and its pose.
struct Spot {
    int page = kUnplaced;
    int x = 0, y = 0, pose = 0;
};

/// Pages are filled by rows from the top.
struct Layout {
    Layout(std::span<const PageSize> page_sizes, int num_shapes)
        : pages(page_sizes.begin(), page_sizes.end()),
          used_height(page_sizes.size(), 0),
          spots(static_cast<std::size_t>(num_shapes)) {}

    Spot& spot(int rank) { return spots[static_cast<std::size_t>(rank)]; }
    const Spot& spot(int rank) const { return spots[static_cast<std::size_t>(rank)]; }

    std::vector<PageSize> pages;
    std::vector<int> used_height;  ///< per page
    std::vector<Spot> spots;       ///< by rank
};

/// A strip of a page that is filled from left to right: scan line y + j is free from edge[j] up to,
/// not including, `limit`.
struct Row {
    int page = 0, y = 0, height = 0, limit = 0;
    std::vector<std::int16_t> edge;  ///< padded to whole blocks

    Row(int page_, int y_, int height_, int limit_)
        : page(page_), y(y_), height(height_), limit(limit_) {
        edge.assign(static_cast<std::size_t>(num_blocks(height_) * kBlock), 0);
    }
};

/// Smallest x at which the profile clears the row's edge: max of edge[j] - profile[j].
inline int leftmost(const std::int16_t* edge, const std::int16_t* profile, int blocks) {
    std::int16_t best[kBlock];
    for (int k = 0; k < kBlock; ++k) best[k] = static_cast<std::int16_t>(edge[k] - profile[k]);
    for (int b = 1; b < blocks; ++b) {
        edge += kBlock;
        profile += kBlock;
        for (int k = 0; k < kBlock; ++k) {
            const auto x = static_cast<std::int16_t>(edge[k] - profile[k]);
            best[k] = best[k] > x ? best[k] : x;
        }
    }
    int x = best[0];
    for (int k = 1; k < kBlock; ++k) x = x > best[k] ? x : best[k];
    return x;
}

/// Puts a shape into a row, `offset` scan lines below its top, and moves the row's edge.
inline void put(const ShapeSet& shapes, int rank, int pose, int x, int offset, Row& row,
                Layout& layout) {
    const ShapeSet::Item& item = shapes[rank];
    const std::int16_t* const right = shapes.left_profile(rank, opposite_side(pose));
    for (int j = 0; j < item.height; ++j)
        row.edge[static_cast<std::size_t>(offset + j)] =
            static_cast<std::int16_t>(x + item.width - right[j]);
    layout.spot(rank) = {row.page, x, row.y + offset, pose};
}

/// A new row at the top of the free part of the first page that has the height.
inline std::optional<Row> new_row(int height, Layout& layout) {
    for (std::size_t p = 0; p < layout.pages.size(); ++p) {
        int& used = layout.used_height[p];
        if (layout.pages[p].height - used < height) continue;
        used += height;
        return Row(static_cast<int>(p), used - height, height, layout.pages[p].width);
    }
    return std::nullopt;
}

}  // namespace pointbake
