#include "atlas/shape_set.h"

#include <algorithm>
#include <cmath>
#include <compare>

#include "core/message.h"

namespace pointbake {
namespace {

std::strong_ordering compare_rows(const PatchShape& a, const PatchShape& b) {
    return std::lexicographical_compare_three_way(
        a.rows.begin(), a.rows.end(), b.rows.begin(), b.rows.end(),
        [](const PatchShape::Span& s, const PatchShape::Span& t) {
            return s.left != t.left ? s.left <=> t.left : s.right <=> t.right;
        });
}

}  // namespace

ShapeSet::ShapeSet(std::span<const PatchShape> shapes) : items_(shapes.size()), tints_(shapes) {
    for (Index i = 0; i < shapes.size(); ++i) {
        Item& item = items_[i];
        item.shape = i;
        item.height = shapes[i].height();
        item.width = shapes[i].width();
        item.num_texels = static_cast<int>(shapes[i].num_texels());
        num_texels_ += item.num_texels;
        max_width_ = std::max(max_width_, item.width);
        max_height_ = std::max(max_height_, item.height);
    }
    std::sort(items_.begin(), items_.end(), [&](const Item& a, const Item& b) {
        if (a.height != b.height) return a.height > b.height;
        if (a.width != b.width) return a.width > b.width;
        if (a.num_texels != b.num_texels) return a.num_texels > b.num_texels;
        const auto order = compare_rows(shapes[a.shape], shapes[b.shape]);
        return order != 0 ? order < 0 : a.shape < b.shape;
    });
    std::size_t size = 0;
    for (Item& item : items_) {
        item.first = size;
        size += static_cast<std::size_t>(kNumPoses * num_blocks(item.height) * kBlock);
    }
    profiles_.assign(size, kNoEdge);
    for (std::size_t rank = 0; rank < items_.size(); ++rank) {
        Item& item = items_[rank];
        const auto& rows = shapes[item.shape].rows;
        if (rank > 0) {
            const Item& last = items_[rank - 1];
            item.group = last.group + (compare_rows(shapes[last.shape], shapes[item.shape]) != 0);
        }
        const auto h = static_cast<std::size_t>(item.height);
        const auto stride = static_cast<std::size_t>(num_blocks(item.height) * kBlock);
        for (std::size_t j = 0; j < h; ++j) {
            const auto left = static_cast<std::int16_t>(rows[j].left);
            const auto right = static_cast<std::int16_t>(item.width - 1 - rows[j].right);
            std::int16_t* const p = profiles_.data() + item.first;
            p[j] = left;
            p[stride + j] = right;
            p[2 * stride + h - 1 - j] = left;
            p[3 * stride + h - 1 - j] = right;
        }
    }
}

void validate(std::span<const PatchShape> shapes, PageSize page) {
    for (std::size_t i = 0; i < shapes.size(); ++i) {
        const PatchShape& shape = shapes[i];
        if (!std::isfinite(shape.color.x + shape.color.y + shape.color.z))
            fail(ErrorCode::kInvalidInput, "the colour of patch {} is not finite", i);
        int first = INT32_MAX;
        for (const PatchShape::Span& row : shape.rows) {
            if (row.left < 0 || row.right < row.left)
                fail(ErrorCode::kInvalidInput,
                     "patch {} has a row [{}, {}]; rows of at least one texel are accepted", i,
                     row.left, row.right);
            first = std::min(first, row.left);
        }
        if (first != 0)
            fail(ErrorCode::kInvalidInput,
                 "patch {} has {}; at least one row, and one that begins at texel 0, are expected",
                 i, shape.rows.empty() ? "no rows" : "an empty first column");
        const int width = shape.width(), height = shape.height();
        if (width > page.width || height > page.height)
            fail(ErrorCode::kLimit,
                 "patch {} needs {} x {} texels, more than a page of {} x {}; accepted are larger "
                 "pages or coarser patches",
                 i, width, height, page.width, page.height);
    }
}

}  // namespace pointbake
