// Small meshes with clouds on them, for the texture tests.
#pragma once

#include <cmath>
#include <functional>

#include "core/color.h"
#include "pointbake/texture.h"

namespace pointbake {

struct Painted {
    Mesh mesh;
    PointCloud cloud;
    std::vector<Index> owners;
};

/// The unit square in z = 0, cut along its diagonal, with n x n points on a grid. `paint` gives
/// sRGB in [0, 1].
inline Painted painted_square(int n, const std::function<Vec3d(double, double)>& paint) {
    Painted out;
    out.mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    out.mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    for (int j = 0; j < n; ++j) {
        for (int i = 0; i < n; ++i) {
            const double x = (i + 0.5) / n, y = (j + 0.5) / n;
            const Vec3d c = paint(x, y);
            const auto code = [](double v) {
                return static_cast<std::uint16_t>(v * 65535.0 + 0.5);
            };
            out.cloud.positions.push_back({x, y, 0.0});
            out.cloud.colors.push_back({code(c.x), code(c.y), code(c.z)});
            out.cloud.normals.push_back({0.0F, 0.0F, 1.0F});
            out.cloud.areas.push_back(static_cast<float>(1.0 / (n * n)));
            out.cloud.rows.push_back(out.cloud.rows.size());
            out.owners.push_back(y <= x ? 0 : 1);
        }
    }
    return out;
}

inline Vec3d wave(double x, double y) {
    return {0.5 + 0.3 * std::sin(12.0 * x), 0.5 + 0.3 * std::cos(9.0 * y),
            0.5 + 0.2 * std::sin(8.0 * (x + y))};
}

inline const TextureOptions kTriangles = [] {
    TextureOptions options;
    options.atlas = AtlasKind::kTriangles;
    return options;
}();

/// Bakes a plan into one page per patch, without packing.
inline BakedTexture bake_apart(const TextureBaker& baker, const TexturePlan& plan,
                               double bound = HUGE_VAL, const Context& context = {}) {
    std::vector<PageSize> pages;
    std::vector<Placement> places;
    for (const PatchShape& shape : plan.shapes) {
        places.push_back({static_cast<Index>(pages.size()), 0, 0, false, false});
        pages.push_back({shape.width(), shape.height()});
    }
    return baker.bake(plan, bound, pages, places, context);
}

/// The colour of the model at barycentrics of a triangle: a bilinear lookup in linear light, as
/// sRGB on the 8-bit scale.
inline Vec3d color_at(const TexturedMesh& model, Index triangle, Vec3d b) {
    const Image& page = model.images[model.triangle_materials[triangle]];
    const auto& uv = model.mesh.uvs[triangle];
    double u = 0.0, v = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
        u += b[k] * static_cast<double>(uv[k].x), v += b[k] * static_cast<double>(uv[k].y);
    }
    const double x = u * page.width - 0.5, y = v * page.height - 0.5;
    const auto texel = [&](double i, double j) {
        const int ci = std::min(std::max(static_cast<int>(i), 0), page.width - 1);
        const int cj = std::min(std::max(static_cast<int>(j), 0), page.height - 1);
        Vec3d out;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t at =
                3 * (static_cast<std::size_t>(cj) * static_cast<std::size_t>(page.width) +
                     static_cast<std::size_t>(ci));
            out[k] = srgb_to_linear_exact(page.pixels[at + k] / 255.0);
        }
        return out;
    };
    const double x0 = std::floor(x + 1e-6), y0 = std::floor(y + 1e-6), fx = x - x0, fy = y - y0;
    const Vec3d mix = (texel(x0, y0) * (1 - fx) + texel(x0 + 1, y0) * fx) * (1 - fy) +
                      (texel(x0, y0 + 1) * (1 - fx) + texel(x0 + 1, y0 + 1) * fx) * fy;
    return {255 * linear_to_srgb_exact(mix.x), 255 * linear_to_srgb_exact(mix.y),
            255 * linear_to_srgb_exact(mix.z)};
}

/// RMS over places of the square, in 8-bit steps.
inline double rms_against(const TexturedMesh& model,
                          const std::function<Vec3d(double, double)>& truth) {
    double sum = 0.0;
    int count = 0;
    for (int j = 2; j < 48; ++j) {
        for (int i = 2; i < 48; ++i) {
            const double x = (i + 0.3) / 50, y = (j + 0.6) / 50;
            const Index t = y <= x ? 0 : 1;
            const Vec3d b = t == 0 ? Vec3d{1 - x, x - y, y} : Vec3d{1 - y, x, y - x};
            const Vec3d d = color_at(model, t, b) - truth(x, y) * 255.0;
            sum += squared_length(d) / 3.0;
            ++count;
        }
    }
    return std::sqrt(sum / count);
}

}  // namespace pointbake
