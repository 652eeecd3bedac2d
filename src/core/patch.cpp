// The need set follows from convexity: the part of the triangle inside the open slab
// j-1 < y < j+1 projects onto an interval of x, and texel (i, j) is needed iff i-1 < x < i+1 meets
// it. Its ends are corners inside the slab or crossings of edges with the slab's two borders.
#include "pointbake/patch.h"

#include <algorithm>
#include <cmath>

#include "core/message.h"

namespace pointbake {
namespace {

// A texel that is read with a weight below this is not needed. It absorbs the rounding of
// coordinates that were meant to be integers (1e-12 at 4096), and one 8-bit step is 4e-3.
constexpr double kNegligibleWeight = 1e-7;

// Corners farther out than this cannot belong to a page, and would not fit an int.
constexpr double kLargestCoordinate = 1 << 24;

struct Interval {
    double low = HUGE_VAL, high = -HUGE_VAL;
    void extend(double x) {
        low = std::min(low, x);
        high = std::max(high, x);
    }
};

int first_texel(double low) { return static_cast<int>(std::floor(low + kNegligibleWeight)); }
int last_texel(double high) { return static_cast<int>(std::ceil(high - kNegligibleWeight)); }

// Extent in x of the triangle between y = low and y = high, which it must meet.
Interval clip_to_slab(const std::array<Vec2d, 3>& corners, double low, double high) {
    Interval x;
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec2d a = corners[k], b = corners[(k + 1) % 3];
        if (a.y >= low && a.y <= high) x.extend(a.x);
        for (const double y : {low, high}) {
            if ((a.y < y) == (b.y < y)) continue;
            // One division: exact to the last bit for integers, where the quotient is an integer
            // or at least 1 / (b.y - a.y) away from one.
            x.extend((a.x * (b.y - y) + b.x * (y - a.y)) / (b.y - a.y));
        }
    }
    return x;
}

}  // namespace

int PatchShape::width() const {
    int right = -1;
    for (const Span& row : rows) right = std::max(right, row.right);
    return right + 1;
}

std::int64_t PatchShape::num_texels() const {
    std::int64_t sum = 0;
    for (const Span& row : rows) sum += row.right - row.left + 1;
    for (const Gap& gap : gaps) sum -= gap.span.right - gap.span.left + 1;
    return sum;
}

NeedSet need_set(const std::array<Vec2d, 3>& corners) {
    Interval x, y;
    for (const Vec2d& c : corners) {
        if (!(std::fabs(c.x) <= kLargestCoordinate && std::fabs(c.y) <= kLargestCoordinate))
            fail(ErrorCode::kLimit,
                 "a patch corner lies at texel ({}, {}); coordinates up to {} are accepted", c.x,
                 c.y, kLargestCoordinate);
        x.extend(c.x);
        y.extend(c.y);
    }
    NeedSet out;
    out.offset_x = first_texel(x.low);
    out.offset_y = first_texel(y.low);
    const int last_row = last_texel(y.high);
    out.shape.rows.reserve(static_cast<std::size_t>(last_row - out.offset_y + 1));
    for (int j = out.offset_y; j <= last_row; ++j) {
        const Interval row = clip_to_slab(corners, j - 1.0, j + 1.0);
        out.shape.rows.push_back(
            {first_texel(row.low) - out.offset_x, last_texel(row.high) - out.offset_x});
    }
    return out;
}

NeedSet need_set(std::span<const std::uint8_t> marked, int width) {
    NeedSet out;
    const auto w = static_cast<std::size_t>(width);
    std::vector<std::span<const std::uint8_t>> rows;
    for (std::size_t first = 0; first + w <= marked.size(); first += w) {
        const auto row = marked.subspan(first, w);
        if (std::any_of(row.begin(), row.end(), [](std::uint8_t m) { return m != 0; }))
            rows.push_back(row);
        else if (rows.empty())
            ++out.offset_y;
    }
    out.offset_x = width;
    for (const auto row : rows) {
        const auto is_marked = [](std::uint8_t m) { return m != 0; };
        const auto first = std::find_if(row.begin(), row.end(), is_marked);
        const auto last = std::find_if(row.rbegin(), row.rend(), is_marked);
        out.shape.rows.push_back({static_cast<int>(first - row.begin()),
                                  width - 1 - static_cast<int>(last - row.rbegin())});
        out.offset_x = std::min(out.offset_x, out.shape.rows.back().left);
    }
    for (std::size_t j = 0; j < rows.size(); ++j) {
        PatchShape::Span& span = out.shape.rows[j];
        for (int i = span.left; i <= span.right; ++i) {
            if (rows[j][static_cast<std::size_t>(i)] != 0) continue;
            PatchShape::Gap gap{static_cast<int>(j), {i - out.offset_x, 0}};
            while (rows[j][static_cast<std::size_t>(i)] == 0) ++i;
            gap.span.right = i - 1 - out.offset_x;
            out.shape.gaps.push_back(gap);
        }
        span.left -= out.offset_x;
        span.right -= out.offset_x;
    }
    return out;
}

}  // namespace pointbake
