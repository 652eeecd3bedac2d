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
        (source.kind == MapKind::kColor ? material.color_image : material.normal_image) =
            static_cast<int>(i);
        out.model.images.push_back(std::move(image));
        out.model.materials.push_back(std::move(material));
    }
    if (source.kind == MapKind::kNormal) {
        out.model.corner_tangents.resize(mesh.triangles.size());
        out.model.tangent_signs.resize(mesh.triangles.size());
    }
    return out;
}

void RawErrors::measure(Index triangle, const PatchTexels& patch) {
    const Footprints& prints = source_.scene.prints;
    const std::span<const Footprint> own = prints.of(triangle);
    for (std::size_t k = 0; k < own.size(); ++k) {
        const std::size_t item = prints.begin[triangle] + k;
        const Vec3f read =
            sample_bilinear(patch, source_.kind, patch.layout.texel_of(own[k].center));
        const Vec3f d = to_steps(source_.kind, read) - to_steps(source_.kind, source_.raw[item]);
        errors_[item] = std::sqrt(squared_length(d) / 3.0F);
    }
}

void RawErrors::summarise(BakedTexture& out) {
    if (errors_.empty()) return;
    double sum = 0.0;
    for (const float e : errors_) sum += static_cast<double>(e) * static_cast<double>(e);
    out.raw_rms = std::sqrt(sum / static_cast<double>(errors_.size()));
    const auto p99 = errors_.begin() + static_cast<std::ptrdiff_t>(errors_.size() * 99 / 100);
    std::nth_element(errors_.begin(), p99, errors_.end());
    out.raw_p99 = static_cast<double>(*p99);
}

void settle_tangent(const PaintSource& source, Index triangle, const Placement& placement,
                    PatchTexels& patch, TexturedMesh& model) {
    if (source.kind != MapKind::kNormal) return;
    const Shell& shell = source.scene.shell;
    const TangentFrame tangent = tangent_frame(shell.frame(triangle), patch.layout, placement);
    to_tangent_space(patch, shell, triangle, tangent);
    model.corner_tangents[triangle] = tangent.tangent;
    model.tangent_signs[triangle] = tangent.sign;
}

}  // namespace pointbake
