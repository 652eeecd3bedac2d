// What texture hands to atlas: the texels that a patch needs, as row spans.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "pointbake/types.h"

namespace pointbake {

/// The texels that bilinear sampling of a patch can read (its need set), as one span [left, right]
/// per row. Row 0 is the top one; left >= 0 and the smallest left is 0; every row of [0, height)
/// has at least one texel.
struct PatchShape {
    struct Span {
        std::int32_t left = 0, right = -1;
    };
    std::vector<Span> rows;

    int height() const { return static_cast<int>(rows.size()); }
    int width() const;
    std::int64_t num_texels() const;
};

/// The exact need set of a triangle whose corners are given in texels, integer coordinates being
/// texel centres (algorithms 7.1: texel (i, j) is needed iff the open square of half-size 1 around
/// its centre meets the triangle). Returns the shape and the integer offset of its texel (0, 0):
/// patch texel = corner coordinate - offset.
struct NeedSet {
    PatchShape shape;
    int offset_x = 0, offset_y = 0;
};
NeedSet need_set(const std::array<Vec2d, 3>& corners);

/// How a patch lies in its page. Patch texel (i, j) of a w x h shape lies at (x + i', y + j') with
/// i' = w-1-i if mirror_x, j' = h-1-j if mirror_y; both = rotated by 180 degrees.
struct Placement {
    Index page = 0;
    int x = 0, y = 0;
    bool mirror_x = false, mirror_y = false;
};

struct PageSize {
    int width = 0, height = 0;
};
inline std::int64_t num_texels(PageSize page) { return std::int64_t{page.width} * page.height; }
inline std::int64_t num_texels(std::span<const PageSize> pages) {
    std::int64_t sum = 0;
    for (const PageSize page : pages) sum += num_texels(page);
    return sum;
}

}  // namespace pointbake
