#include "texture/paint_pages.h"

#include <algorithm>
#include <cmath>

#include "core/message.h"

namespace pointbake {

BakedTexture empty_pages(const PaintSource& source, std::span<const PageSize> pages) {
    BakedTexture out;
    const Mesh& mesh = source.scene.mesh;
    out.model.mesh = mesh;
    out.model.mesh.normals = source.scene.shell.normals();
    out.model.mesh.uvs.resize(mesh.triangles.size());
    out.model.triangle_materials.resize(mesh.triangles.size());
    for (std::size_t i = 0; i < pages.size(); ++i) {
        Image image{pages[i].width, pages[i].height, 3, {}};
        image.pixels.assign(image.num_texels() * 3, 0);
        out.owned.emplace_back(image.num_texels(), std::uint8_t{0});
        Material material;
        material.name = fmt::format("page{}", i);
        (source.map.kind == MapKind::kColor ? material.color_image : material.normal_image) =
            static_cast<int>(i);
        out.model.images.push_back(std::move(image));
        out.model.materials.push_back(std::move(material));
    }
    if (source.map.kind == MapKind::kNormal) {
        out.model.corner_tangents.resize(mesh.triangles.size());
        out.model.tangent_signs.resize(mesh.triangles.size());
    }
    return out;
}

void RawErrors::measure(Index triangle, const std::function<Vec3f(Vec2f)>& read) {
    const Footprints& prints = source_.scene.prints;
    const MapKind kind = source_.map.kind;
    const std::span<const Footprint> own = prints.of(triangle);
    for (std::size_t k = 0; k < own.size(); ++k) {
        if (own[k].hidden) continue;
        const std::size_t item = prints.begin[triangle] + k;
        const Vec3f d = to_steps(kind, read(own[k].center)) - to_steps(kind, source_.raw[item]);
        errors_[item] = std::sqrt(squared_length(d) / 3.0F);
    }
}

void RawErrors::measure(Index triangle, const PatchTexels& patch) {
    measure(triangle, [&](Vec2f place) {
        return sample_bilinear(patch, source_.map.kind, patch.layout.texel_of(place));
    });
}

void RawErrors::summarise(TextureReport& out) const {
    std::vector<float> seen;
    double sum = 0.0;
    for (std::size_t i = 0; i < errors_.size(); ++i) {
        if (source_.scene.prints.items[i].hidden) continue;
        seen.push_back(errors_[i]);
        sum += static_cast<double>(errors_[i]) * static_cast<double>(errors_[i]);
    }
    if (seen.empty()) return;
    out.raw_rms = std::sqrt(sum / static_cast<double>(seen.size()));
    const auto p99 = seen.begin() + static_cast<std::ptrdiff_t>(seen.size() * 99 / 100);
    std::nth_element(seen.begin(), p99, seen.end());
    out.raw_p99 = static_cast<double>(*p99);
}

void settle_tangent(const PaintSource& source, Index triangle, const Placement& placement,
                    PatchTexels& patch, TexturedMesh& model) {
    if (source.map.kind != MapKind::kNormal) return;
    const Shell& shell = source.scene.shell;
    const TangentFrame tangent = tangent_frame(shell.frame(triangle), patch.layout, placement);
    to_tangent_space(patch, shell, triangle, tangent);
    model.corner_tangents[triangle] = tangent.tangent;
    model.tangent_signs[triangle] = tangent.sign;
}

}  // namespace pointbake
