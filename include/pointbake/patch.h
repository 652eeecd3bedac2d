// What texture hands to atlas: the texels that a patch needs, as row spans.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "pointbake/types.h"

namespace pointbake {

/// The texels that a patch needs: those that bilinear sampling can read (its need set) and its
/// gutter. One span [left, right] per row, less the gaps in it. Row 0 is the top one; left >= 0 and
/// the smallest left is 0; every row of [0, height) has at least one texel.
struct PatchShape {
    struct Span {
        std::int32_t left = 0, right = -1;
    };
    struct Gap {
        std::int32_t row = 0;
        Span span;
    };
    std::vector<Span> rows;
    /// Mean of what it shows, finite, in the map's own coding (sRGB 0 to 1, or a normal): like ones
    /// are laid side by side, where they may bleed into each other.
    Vec3f color{};
    std::vector<Gap> gaps{};  ///< inside the rows' spans, ascending, apart; one triangle has none

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
/// The set of the texels that are marked, one byte per texel, row by row. No row between the first
/// and the last one that has any may be empty.
NeedSet need_set(std::span<const std::uint8_t> marked, int width);

/// How a patch lies in its page. Patch texel (i, j) of a w x h shape lies at (x + i', y + j') with
/// i' = w-1-i if mirror_x, j' = h-1-j if mirror_y; both = rotated by 180 degrees. If transposed, i'
/// and j' are swapped after that.
struct Placement {
    Index page = 0;
    int x = 0, y = 0;
    bool mirror_x = false, mirror_y = false, transposed = false;
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
