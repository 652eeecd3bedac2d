// How a model's materials look in formats that have both lit and unlit ones.
#pragma once

#include "pointbake/types.h"
#include "pointbake/write.h"

namespace pointbake {

/// How a material is drawn, and so what its vertices need.
struct Look {
    bool is_lit = false;
    bool has_color_image = false;
    bool has_normal_image = false;
    bool has_vertex_colors = false;
    bool has_uvs() const { return has_color_image || has_normal_image; }
};

inline Look look_of(const Mesh& mesh, const Material& material, Shading shading) {
    Look look;
    look.has_color_image = !mesh.uvs.empty() && material.color_image >= 0;
    look.has_normal_image = !mesh.uvs.empty() && material.normal_image >= 0;
    // A viewer would multiply a texture by vertex colours.
    look.has_vertex_colors = !look.has_color_image && !mesh.colors.empty();
    const bool has_color = look.has_color_image || look.has_vertex_colors ||
                           material.base_color != std::array<double, 3>{1.0, 1.0, 1.0};
    // Unlit, a normal map would be ignored and a surface without colour be a white outline.
    look.is_lit = shading == Shading::kLit || look.has_normal_image || !has_color;
    return look;
}

}  // namespace pointbake
