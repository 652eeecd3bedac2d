// Mip maps [Williams83], filtered in linear light.
#include "sample/color_source.h"

#include <algorithm>
#include <cmath>

#include "core/color.h"
#include "core/parallel.h"

namespace pointbake {
namespace {

constexpr std::size_t kRowGrain = 16;  // rows per chunk

std::uint16_t root_of(double linear) {
    return static_cast<std::uint16_t>(std::sqrt(linear) * 65535.0 + 0.5);
}
double linear_of(std::uint16_t root) { return (root / 65535.0) * (root / 65535.0); }

MipLevel first_level(const Image& image, const Context& context) {
    std::array<std::uint16_t, 256> root;
    for (unsigned v = 0; v < 256; ++v) root[v] = root_of(srgb_to_linear_exact(v / 255.0));
    MipLevel level{image.width, image.height, {}};
    level.texels.resize(image.num_texels());
    const auto width = static_cast<std::size_t>(image.width);
    const auto channels = static_cast<std::size_t>(image.num_channels);
    const std::size_t step = channels >= 3 ? 1 : 0;  // one or two channels: grey (and alpha)
    parallel_for(context, static_cast<std::size_t>(image.height), kRowGrain,
                 [&](std::size_t begin, std::size_t end) {
                     for (std::size_t i = begin * width; i < end * width; ++i)
                         for (std::size_t k = 0; k < 3; ++k)
                             level.texels[i][k] = root[image.pixels[i * channels + k * step]];
                 });
    return level;
}

/// The texels of a line of `from` that one of the `to` texels at `i` covers, and their shares in
/// units of 1 / to.
struct Cover {
    std::int64_t first, last, from, to, begin, end;

    Cover(std::int64_t i, std::int64_t from_, std::int64_t to_)
        : from(from_), to(to_), begin(i * from_), end((i + 1) * from_) {
        first = begin / to;
        last = (end - 1) / to;
    }
    std::uint64_t share(std::int64_t k) const {
        return static_cast<std::uint64_t>(std::min(end, (k + 1) * to) - std::max(begin, k * to));
    }
};

MipLevel halved(const MipLevel& from, const Context& context) {
    MipLevel to{std::max(1, from.width / 2), std::max(1, from.height / 2), {}};
    to.texels.resize(static_cast<std::size_t>(to.width) * static_cast<std::size_t>(to.height));
    const double whole = static_cast<double>(from.width) * from.height;
    parallel_for(context, static_cast<std::size_t>(to.height), kRowGrain,
                 [&](std::size_t begin, std::size_t end) {
                     for (auto y = static_cast<std::int64_t>(begin);
                          y < static_cast<std::int64_t>(end); ++y) {
                         const Cover rows(y, from.height, to.height);
                         for (std::int64_t x = 0; x < to.width; ++x) {
                             const Cover columns(x, from.width, to.width);
                             std::array<std::uint64_t, 3> sum{};
                             for (std::int64_t j = rows.first; j <= rows.last; ++j)
                                 for (std::int64_t i = columns.first; i <= columns.last; ++i) {
                                     const std::uint64_t share = rows.share(j) * columns.share(i);
                                     const auto& texel =
                                         from.texels[static_cast<std::size_t>(j * from.width + i)];
                                     for (std::size_t k = 0; k < 3; ++k)
                                         sum[k] += share * texel[k] * texel[k];
                                 }
                             auto& texel = to.texels[static_cast<std::size_t>(y * to.width + x)];
                             for (std::size_t k = 0; k < 3; ++k)
                                 texel[k] = static_cast<std::uint16_t>(
                                     std::sqrt(static_cast<double>(sum[k]) / whole) + 0.5);
                         }
                     }
                 });
    return to;
}

/// Index of a texel in a texture that repeats.
std::size_t repeated(double i, int size) {
    const double n = size;
    const double r = i - n * std::floor(i / n);
    return r < n ? static_cast<std::size_t>(r) : 0U;
}

/// `at` in texels, (0, 0) at the upper left corner of the image.
std::array<double, 3> bilinear(const MipLevel& level, Vec2d at) {
    const Vec2d p{at.x - 0.5, at.y - 0.5};
    const Vec2d low{std::floor(p.x), std::floor(p.y)};
    const Vec2d f = p - low;
    std::array<double, 3> sum{};
    for (int j = 0; j < 2; ++j)
        for (int i = 0; i < 2; ++i) {
            const double weight = (i ? f.x : 1.0 - f.x) * (j ? f.y : 1.0 - f.y);
            const std::size_t x = repeated(low.x + i, level.width);
            const std::size_t y = repeated(low.y + j, level.height);
            const auto& texel = level.texels[y * static_cast<std::size_t>(level.width) + x];
            for (std::size_t k = 0; k < 3; ++k) sum[k] += weight * linear_of(texel[k]);
        }
    return sum;
}

std::uint16_t coded(double linear) {
    return static_cast<std::uint16_t>(linear_to_srgb_exact(linear) * 65535.0 + 0.5);
}

}  // namespace

std::vector<MipLevel> make_mips(const Image& image, const Context& context) {
    if (image.num_texels() == 0) return {};
    std::vector<MipLevel> mips{first_level(image, context)};
    while (mips.back().width > 1 || mips.back().height > 1)
        mips.push_back(halved(mips.back(), context));
    return mips;
}

ColorSource::ColorSource(const TexturedMesh& model, const Context& context)
    : model_(model), mips_(model.images.size()) {
    if (model.mesh.uvs.empty()) return;
    for (const Material& material : model.materials) {
        const auto image = static_cast<std::size_t>(material.color_image);
        if (material.color_image >= 0 && image < mips_.size() && mips_[image].empty())
            mips_[image] = make_mips(model.images[image], context);
    }
}

bool ColorSource::has_colors() const {
    return !model_.materials.empty() || !model_.mesh.colors.empty();
}

const Material* ColorSource::material_of(Index triangle) const {
    const std::size_t i =
        model_.triangle_materials.empty() ? 0U : model_.triangle_materials[triangle];
    return i < model_.materials.size() ? &model_.materials[i] : nullptr;
}

Rgb16 ColorSource::color(const SurfaceSample& sample, double spacing) const {
    const Material* material = material_of(sample.triangle);
    Linear linear{1.0, 1.0, 1.0};
    const auto image = static_cast<std::size_t>(material ? material->color_image : -1);
    if (image < mips_.size() && !mips_[image].empty())
        linear = texture_color(mips_[image], sample, spacing);
    else if (!model_.mesh.colors.empty())
        linear = vertex_color(sample);
    if (material)
        for (std::size_t k = 0; k < 3; ++k) linear[k] *= material->base_color[k];
    return {coded(linear[0]), coded(linear[1]), coded(linear[2])};
}

ColorSource::Linear ColorSource::texture_color(std::span<const MipLevel> mips,
                                               const SurfaceSample& sample, double spacing) const {
    const auto& corners = model_.mesh.uvs[sample.triangle];
    const Vec2d a = {static_cast<double>(corners[0].x), static_cast<double>(corners[0].y)};
    const Vec2d ab =
        Vec2d{static_cast<double>(corners[1].x), static_cast<double>(corners[1].y)} - a;
    const Vec2d ac =
        Vec2d{static_cast<double>(corners[2].x), static_cast<double>(corners[2].y)} - a;

    // Both areas are twice the triangle's; a texel of the next level covers four.
    const double area = length(TriangleFrame(model_.mesh, sample.triangle).normal());
    const double num_texels = std::fabs(cross(ab, ac)) * mips[0].width * mips[0].height;
    std::size_t level = 0;
    double texels_per_spacing = spacing * spacing * num_texels;  // times the area
    while (level + 1 < mips.size() && texels_per_spacing >= 4.0 * area) {
        texels_per_spacing *= 0.25;
        ++level;
    }
    const Vec2d uv = a + ab * sample.u + ac * sample.v;
    return bilinear(mips[level], {uv.x * mips[level].width, uv.y * mips[level].height});
}

ColorSource::Linear ColorSource::vertex_color(const SurfaceSample& sample) const {
    const Triangle& t = model_.mesh.triangles[sample.triangle];
    const std::array<double, 3> weights{1.0 - sample.u - sample.v, sample.u, sample.v};
    Linear sum{};
    for (std::size_t corner = 0; corner < 3; ++corner) {
        const Vec3f linear = to_linear(model_.mesh.colors[t[corner]]);
        for (std::size_t k = 0; k < 3; ++k)
            sum[k] += weights[corner] * static_cast<double>(linear[k]);
    }
    return sum;
}

}  // namespace pointbake
