#include "atlas/tints.h"

#include <algorithm>
#include <numeric>

namespace pointbake {
namespace {

constexpr std::size_t kParts = std::tuple_size_v<Tints::Row>;
constexpr double kMeanDistance = 1.0 / 3.0;
constexpr double kSameColor = 1e-6;  // mean difference: roundings

// Along the longest side of the box at each branch.
void sort_by_color(std::span<Index> items, std::span<const PatchShape> shapes) {
    if (items.size() < 3) return;
    Box box;
    for (const Index i : items) box.extend(vec_cast<double>(shapes[i].color));
    const Vec3d e = box.extent();
    const std::size_t axis = e.x >= e.y && e.x >= e.z ? 0 : (e.y >= e.z ? 1 : 2);
    const auto middle = items.begin() + static_cast<std::ptrdiff_t>(items.size() / 2);
    std::nth_element(items.begin(), middle, items.end(), [&](Index a, Index b) {
        const float x = shapes[a].color[axis], y = shapes[b].color[axis];
        return x != y ? x < y : a < b;
    });
    sort_by_color({items.begin(), middle}, shapes);
    sort_by_color({middle, items.end()}, shapes);
}

struct MeanColor {
    Vec3f sum{};
    float weight = 0.0F;
    void add(Vec3f color, float w) { sum += color * w, weight += w; }
};

}  // namespace

std::vector<Index> order_by_color(std::span<const PatchShape> shapes) {
    std::vector<Index> sorted(shapes.size()), place(shapes.size());
    std::iota(sorted.begin(), sorted.end(), Index{0});
    sort_by_color(sorted, shapes);
    for (Index i = 0; i < sorted.size(); ++i) place[sorted[i]] = i;
    return place;
}

Tints::Tints(std::span<const PatchShape> shapes) : order_(order_by_color(shapes)) {
    for (const PatchShape& shape : shapes) {
        colors_.push_back(shape.color);
        sizes_.push_back(static_cast<float>(shape.num_texels()));
    }
    std::vector<Index> all(shapes.size());
    std::iota(all.begin(), all.end(), Index{0});
    double sum = 0.0, total = 0.0;
    const Row row = row_of(std::move(all));
    for (std::size_t i = 0; i < colors_.size(); ++i)
        for (const Vec3f& color : row) {
            sum += static_cast<double>(sizes_[i] * length(colors_[i] - color));
            total += static_cast<double>(sizes_[i]);
        }
    if (sum > kSameColor * total) scale_ = static_cast<float>(kMeanDistance * total / sum);
}

Tints::Row Tints::row_of(std::vector<Index> shapes) const {
    std::sort(shapes.begin(), shapes.end(),
              [&](Index a, Index b) { return order_[a] < order_[b]; });
    double total = 0.0, before = 0.0;
    for (const Index i : shapes) total += static_cast<double>(sizes_[i]);
    std::array<MeanColor, kParts> parts;
    for (const Index i : shapes) {
        const auto size = static_cast<double>(sizes_[i]);
        const auto part = static_cast<std::size_t>((before + 0.5 * size) / total * kParts);
        parts[std::min(part, kParts - 1)].add(colors_[i], sizes_[i]);
        before += size;
    }
    Row row{};
    std::size_t filled = 0;  // parts so far
    for (std::size_t k = 0; k < kParts; ++k) {
        if (parts[k].weight == 0.0F) continue;
        // A shape wider than a part is what belongs in those that it covers: the nearest one.
        const Vec3f color = parts[k].sum / parts[k].weight;
        const std::size_t from = filled == 0 ? 0 : (filled + k + 1) / 2;
        for (std::size_t j = filled; j < from; ++j) row[j] = row[filled - 1];
        for (std::size_t j = from; j <= k; ++j) row[j] = color;
        filled = k + 1;
    }
    for (std::size_t j = filled; j < kParts && filled > 0; ++j) row[j] = row[filled - 1];
    return row;
}

double Tints::distance(Index shape, const Row& row, double x) const {
    const double at = std::clamp(x * kParts - 0.5, 0.0, kParts - 1.0);
    const auto part = static_cast<std::size_t>(at);
    const auto share = static_cast<float>(at - static_cast<double>(part));
    const Vec3f wanted = row[part] + (row[std::min(part + 1, kParts - 1)] - row[part]) * share;
    return static_cast<double>(scale_ * length(colors_[shape] - wanted));
}

}  // namespace pointbake
