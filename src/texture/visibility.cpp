#include "texture/visibility.h"

#include <algorithm>
#include <cmath>
#include <compare>
#include <numeric>
#include <span>

#include "core/parallel.h"

namespace pointbake {
namespace {

constexpr std::size_t kGrain = 64;  // triangles per chunk
// In spacings: radius of a disc (they overlap), and the gap that makes two layers. The discs of one
// side of a ridge reach over the other's points; a gap of 1.5 took those for layers (a teapot's
// spout).
constexpr double kDisc = 1.2, kGap = 2.5;
// Layers are roughly parallel; the two sides of a ridge are not.
constexpr double kAlike = 0.5;
constexpr double kMinFacing = 0.25;
constexpr std::size_t kFewest = 2;  // discs over a point; one alone is an outlier
constexpr double kLargest = 4.0;    // spacing of a point over the mean in its triangle
constexpr float kCellsPerPoint = 4.0F;

class TriangleLayers {
 public:
    TriangleLayers(const PointCloud& cloud, const Shell& shell) : cloud_(cloud), shell_(shell) {}

    void hide(Index triangle, std::span<Footprint> prints) {
        triangle_ = triangle;
        prints_ = prints;
        if (!may_have_layers()) return;
        sort_into_cells();
        covered_.assign(prints.size(), 0);
        for (std::size_t i = 0; i < prints.size(); ++i) covered_[i] = is_covered(i) ? 1 : 0;
        for (std::size_t i = 0; i < prints.size(); ++i)
            if (covered_[i] != 0) prints[i].hidden = true;
    }

 private:
    // Of an outlier no more than kLargest times what is usual in the triangle.
    double spacing(const Footprint& f) const {
        return std::min(std::sqrt(static_cast<double>(cloud_.areas[f.point])), largest_);
    }
    // Depths are along the interpolated normal, which is not longer than 1: no smaller than
    // heights.
    bool may_have_layers() {
        float low = HUGE_VALF, high = -HUGE_VALF;
        double least = HUGE_VAL, most = 0.0, sum = 0.0;
        for (const Footprint& f : prints_) {
            low = std::min(low, f.depth);
            high = std::max(high, f.depth);
            const double s = std::sqrt(static_cast<double>(cloud_.areas[f.point]));
            least = std::min(least, s);
            most = std::max(most, s);
            sum += s;
        }
        largest_ = std::min(most, kLargest * sum / static_cast<double>(prints_.size()));
        return static_cast<double>(high) - static_cast<double>(low) > kGap * least;
    }

    void sort_into_cells() {
        Vec2f low{HUGE_VALF, HUGE_VALF}, high{-HUGE_VALF, -HUGE_VALF};
        for (const Footprint& f : prints_) {
            low = {std::min(low.x, f.center.x), std::min(low.y, f.center.y)};
            high = {std::max(high.x, f.center.x), std::max(high.y, f.center.y)};
        }
        origin_ = low;
        const Vec2f size = high - low;
        const auto cell = static_cast<float>(kDisc * largest_);
        const float num_cells = kCellsPerPoint * static_cast<float>(prints_.size());
        const float least =
            std::max(std::sqrt(size.x * size.y / num_cells), std::max(size.x, size.y) / num_cells);
        per_unit_ = 1.0F / std::max({cell, least, 1e-30F});
        width_ = static_cast<int>(size.x * per_unit_) + 1;
        height_ = static_cast<int>(size.y * per_unit_) + 1;
        begin_.assign(static_cast<std::size_t>(width_ * height_) + 1, 0);
        for (const Footprint& f : prints_) ++begin_[cell_of(column(f), row(f)) + 1];
        std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
        items_.resize(prints_.size());
        next_.assign(begin_.begin(), begin_.end() - 1);
        for (std::size_t i = 0; i < prints_.size(); ++i)
            items_[next_[cell_of(column(prints_[i]), row(prints_[i]))]++] = static_cast<Index>(i);
    }
    int column(const Footprint& f) const {
        return static_cast<int>((f.center.x - origin_.x) * per_unit_);
    }
    int row(const Footprint& f) const {
        return static_cast<int>((f.center.y - origin_.y) * per_unit_);
    }
    std::size_t cell_of(int x, int y) const { return static_cast<std::size_t>(y * width_ + x); }

    // Heights of the discs over a point; a gap among them is a layer.
    bool is_covered(std::size_t i) {
        const Footprint& f = prints_[i];
        if (f.hidden) return false;
        const Vec3d p = cloud_.positions[f.point], n = vec_cast<double>(cloud_.normals[f.point]);
        const Vec3d up = normalized(shell_.normal_at(triangle_, vec_cast<double>(f.center)));
        heights_.clear();
        const int x0 = column(f), y0 = row(f);
        for (int y = std::max(0, y0 - 1); y <= std::min(height_ - 1, y0 + 1); ++y) {
            for (int x = std::max(0, x0 - 1); x <= std::min(width_ - 1, x0 + 1); ++x) {
                for (Index k = begin_[cell_of(x, y)]; k < begin_[cell_of(x, y) + 1]; ++k)
                    add_height(prints_[items_[k]], p, n, up);
            }
        }
        std::sort(heights_.begin(), heights_.end());
        double below = 0.0;
        for (std::size_t k = 0; k < heights_.size(); ++k) {
            if (heights_[k].value - below > kGap * heights_[k].spacing)
                return heights_.size() - k >= kFewest;
            below = heights_[k].value;
        }
        return false;
    }

    void add_height(const Footprint& over, Vec3d p, Vec3d n, Vec3d up) {
        if (over.hidden) return;
        const Vec3d m = vec_cast<double>(cloud_.normals[over.point]);
        const double facing = dot(up, m);
        if (facing < kMinFacing || dot(n, m) < kAlike) return;
        const Vec3d to = cloud_.positions[over.point] - p;
        const double height = dot(to, m) / facing, s = spacing(over);
        if (height > 0.0 && squared_length(up * height - to) < kDisc * kDisc * s * s)
            heights_.push_back({height, s});
    }

    struct Height {
        double value, spacing;
        auto operator<=>(const Height&) const = default;
    };

    const PointCloud& cloud_;
    const Shell& shell_;
    Index triangle_ = kInvalidIndex;
    std::span<Footprint> prints_;
    double largest_ = 0.0;
    Vec2f origin_;
    float per_unit_ = 0.0F;
    int width_ = 0, height_ = 0;
    std::vector<Index> begin_, items_, next_;
    std::vector<Height> heights_;
    std::vector<std::uint8_t> covered_;
};

}  // namespace

void hide_covered_in_place(Footprints& prints, const PointCloud& cloud, const Shell& shell,
                           const Context& context) {
    if (cloud.normals.empty()) return;
    const std::size_t num_triangles = prints.begin.size() - 1;
    parallel_for(context, num_triangles, kGrain, [&](std::size_t begin, std::size_t end) {
        TriangleLayers layers(cloud, shell);
        for (std::size_t t = begin; t < end; ++t)
            layers.hide(static_cast<Index>(t),
                        std::span(prints.items)
                            .subspan(prints.begin[t], prints.begin[t + 1] - prints.begin[t]));
    });
}

}  // namespace pointbake
