// [Zwicker01]: V' = A V A^T + h^2 I, w = sqrt(det A V A^T / det V') exp(-d^T V'^-1 d / 2), t = sum
// w c / sum w. Kernels have unit amplitude in object space: with normalised splatting the densest
// samples must not dominate.
#include "texture/patch_texels.h"

#include <algorithm>
#include <cmath>

namespace pointbake {
namespace {

constexpr float kMinWeight = 1e-4F;  // below, a texel counts as not covered

struct ScreenSplat {
    float x, y, a, b, c;  // centre; q(dx, dy) = a dx^2 + 2 b dx dy + c dy^2
    float radius_y, amplitude;
    Vec3f value, linear;
};

// The splat in texel coordinates; false if it is too thin to have any.
bool to_screen(const LocalSplat& s, const PatchLayout& layout, float low_pass, float cut,
               ScreenSplat& out) {
    const Vec2f x = layout.column_x, y = layout.column_y;
    const float xx = x.x * x.x * s.vxx + 2.0F * x.x * y.x * s.vxy + y.x * y.x * s.vyy;
    const float xy = x.x * x.y * s.vxx + (x.x * y.y + x.y * y.x) * s.vxy + y.x * y.y * s.vyy;
    const float yy = x.y * x.y * s.vxx + 2.0F * x.y * y.y * s.vxy + y.y * y.y * s.vyy;
    const float det_object = xx * yy - xy * xy;
    const float vxx = xx + low_pass, vyy = yy + low_pass;
    const float det = vxx * vyy - xy * xy;
    if (!(det > 0.0F) || !(det_object > 0.0F)) return false;
    const Vec2f center = layout.texel_of(s.center);
    out = {center.x,
           center.y,
           vyy / det,
           -xy / det,
           vxx / det,
           cut * std::sqrt(vyy),
           std::sqrt(det_object / det),
           {},
           {}};
    return true;
}

// Of weight * value and of weight.
struct WeightedSum {
    float x = 0.0F, y = 0.0F, z = 0.0F, weight = 0.0F;
    void add(Vec3f value, float w) {
        x += value.x * w;
        y += value.y * w;
        z += value.z * w;
        weight += w;
    }
    Vec3f mean() const { return Vec3f{x, y, z} / weight; }
};
using Sums = std::vector<WeightedSum>;

// Of the values and, where `kAverages`, of the same in linear light.
template <bool kAverages>
void accumulate(const ScreenSplat& s, const Kernel& kernel, const NeedSet& need, int width,
                Sums& sums, Sums& linear_sums) {
    const int first_row =
        std::max(0, static_cast<int>(std::ceil(s.y - s.radius_y)) - need.offset_y);
    const int last_row = std::min(need.shape.height() - 1,
                                  static_cast<int>(std::floor(s.y + s.radius_y)) - need.offset_y);
    for (int row = first_row; row <= last_row; ++row) {
        // Exact span of q < cut^2 in this row.
        const float dy = static_cast<float>(row + need.offset_y) - s.y;
        const float root = (s.b * s.b - s.a * s.c) * dy * dy + s.a * kernel.cut2;
        if (!(root > 0.0F)) continue;
        const float half = std::sqrt(root) / s.a, middle = s.x - s.b * dy / s.a;
        const PatchShape::Span span = need.shape.rows[static_cast<std::size_t>(row)];
        const int left =
            std::max(span.left, static_cast<int>(std::ceil(middle - half)) - need.offset_x);
        const int right =
            std::min(span.right, static_cast<int>(std::floor(middle + half)) - need.offset_x);
        const auto at = static_cast<std::size_t>(row) * static_cast<std::size_t>(width);
        WeightedSum* const sum = sums.data() + at;
        WeightedSum* const linear_sum = kAverages ? linear_sums.data() + at : nullptr;
        const float linear = 2.0F * s.b * dy, constant = s.c * dy * dy;
        const float shift = static_cast<float>(need.offset_x) - s.x;
        for (int i = left; i <= right; ++i) {
            const float dx = static_cast<float>(i) + shift;
            const float w = s.amplitude * kernel((s.a * dx + linear) * dx + constant);
            sum[i].add(s.value, w);
            if constexpr (kAverages) linear_sum[i].add(s.linear, w);
        }
    }
}

void encode_texels(PatchTexels& patch, MapKind kind) {
    patch.coded.resize(patch.values.size() * 3);
    for (std::size_t i = 0; i < patch.values.size(); ++i) {
        const Texel t = encode(kind, patch.values[i]);
        std::copy(t.begin(), t.end(), patch.coded.begin() + static_cast<std::ptrdiff_t>(3 * i));
    }
}

}  // namespace

PatchLayout patch_layout(const TriangleFrame& frame, double texels_per_unit) {
    PatchLayout out;
    if (texels_per_unit <= kOneTexel || !(frame.height() > 0.0)) {
        // Everything at one texel centre; the splats are filtered as if the texel were as large as
        // the triangle.
        const auto size = static_cast<float>(std::max(frame.base(), 1e-300));
        const TriangleFrame& f = frame;
        const Vec2d middle = (f.corners[0] + f.corners[1] + f.corners[2]) / 3.0;
        out.column_x = {1.0F / size, 0.0F};
        out.column_y = {0.0F, -1.0F / size};
        out.origin = {-static_cast<float>(middle.x) / size, static_cast<float>(middle.y) / size};
        return out;
    }
    const auto whole = [](double x) { return std::max(1, static_cast<int>(x + 0.5)); };
    const double foot = frame.corners[static_cast<std::size_t>((frame.left + 2) % 3)].x;
    out.base = whole(texels_per_unit * frame.base());
    out.height = whole(texels_per_unit * frame.height());
    const double scale_x = out.base / frame.base(), scale_y = out.height / frame.height();
    out.apex = std::clamp(static_cast<int>(std::floor(scale_x * foot + 0.5)), 0, out.base);
    const auto left = static_cast<std::size_t>(frame.left);
    out.corners[left] = {0.0, static_cast<double>(out.height)};
    out.corners[(left + 1) % 3] = {static_cast<double>(out.base), static_cast<double>(out.height)};
    out.corners[(left + 2) % 3] = {static_cast<double>(out.apex), 0.0};
    out.origin = {0.0F, static_cast<float>(out.height)};
    out.column_x = {static_cast<float>(scale_x), 0.0F};
    out.column_y = {static_cast<float>((out.apex - scale_x * foot) / frame.height()),
                    static_cast<float>(-scale_y)};
    return out;
}

PatchLayout patch_layout(const TriangleFrame& frame, const std::array<Vec2d, 3>& texels) {
    PatchLayout out;
    out.corners = texels;
    const Vec2d a = frame.corners[0], d = frame.corners[1] - a, e = frame.corners[2] - a;
    const Vec2d u = texels[1] - texels[0], v = texels[2] - texels[0];
    const double area = cross(d, e);
    const Vec2d x = (u * e.y - v * d.y) / area, y = (v * d.x - u * e.x) / area;
    out.column_x = vec_cast<float>(x);
    out.column_y = vec_cast<float>(y);
    out.origin = vec_cast<float>(texels[0] - x * a.x - y * a.y);
    return out;
}

PatchTexels splat_patch(const LocalField& field, const MapValues& map, const PatchLayout& layout,
                        NeedSet need, TexelFilter filter) {
    PatchTexels patch;
    patch.layout = layout;
    patch.need = std::move(need);
    const int width = patch.width = patch.need.shape.width(), height = patch.need.shape.height();
    const auto num_texels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    const bool averages = !map.linear.empty() && filter.linear_share > 0.0F;
    Sums sums(num_texels), linear(averages ? num_texels : 0);
    for (const LocalSplat& s : field.splats()) {
        ScreenSplat screen;
        if (!to_screen(s, layout, filter.variance, field.kernel().cut, screen)) continue;
        screen.value = map.values[s.item];
        if (averages) {
            screen.linear = map.linear[s.item];
            accumulate<true>(screen, field.kernel(), patch.need, width, sums, linear);
        } else {
            accumulate<false>(screen, field.kernel(), patch.need, width, sums, linear);
        }
    }
    patch.values.resize(num_texels);
    patch.is_uncovered.assign(num_texels, 0);
    for (int row = 0; row < height; ++row) {
        const PatchShape::Span span = patch.need.shape.rows[static_cast<std::size_t>(row)];
        for (int i = span.left; i <= span.right; ++i) {
            const auto at = static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
                            static_cast<std::size_t>(i);
            Vec3f& value = patch.values[at];
            if (sums[at].weight > kMinWeight) {
                value = sums[at].mean();
                if (averages)
                    value += (linear_to_value(linear[at].mean()) - value) * filter.linear_share;
                continue;
            }
            const Vec2f u{static_cast<float>(i + patch.need.offset_x),
                          static_cast<float>(row + patch.need.offset_y)};
            const SplatSum wide = field.evaluate(layout.place_of(u), map.values);
            if (wide.weight > 0.0F) value = wide.sum / wide.weight;
            patch.is_uncovered[at] = 1;
        }
    }
    encode_texels(patch, map.kind);
    return patch;
}

Vec3f sample_bilinear(const PatchTexels& patch, MapKind kind, Vec2f u) {
    const float x = u.x - static_cast<float>(patch.need.offset_x),
                y = u.y - static_cast<float>(patch.need.offset_y);
    const int last_x = patch.width - 1, last_y = patch.need.shape.height() - 1;
    const int x0 = std::clamp(static_cast<int>(std::floor(x)), 0, last_x),
              x1 = std::min(x0 + 1, last_x);
    const int y0 = std::clamp(static_cast<int>(std::floor(y)), 0, last_y),
              y1 = std::min(y0 + 1, last_y);
    const float fx = std::clamp(x - static_cast<float>(x0), 0.0F, 1.0F);
    const float fy = std::clamp(y - static_cast<float>(y0), 0.0F, 1.0F);
    const auto at = [&](int i, int j) { return decode(kind, patch.texel(i, j)); };
    const Vec3f top = at(x0, y0) * (1.0F - fx) + at(x1, y0) * fx;
    const Vec3f bottom = at(x0, y1) * (1.0F - fx) + at(x1, y1) * fx;
    const Vec3f read = top * (1.0F - fy) + bottom * fy;
    return kind == MapKind::kColor ? linear_to_value(read) : read;
}

}  // namespace pointbake
