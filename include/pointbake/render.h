// A small renderer for pictures of what went in and what came out. Supersampled, no window,
// no GPU.
#pragma once

#include <vector>

#include "pointbake/context.h"
#include "pointbake/types.h"

namespace pointbake {

/// Orthographic view: looks along -direction at the centre of the box, `up` upwards.
struct View {
    Vec3d direction{0.55, 0.45, 1.0};  ///< from the model to the viewer; need not be unit length
    Vec3d up{0.0, 1.0, 0.0};
    double zoom = 1.0;  ///< 1 = the bounding sphere fills the smaller side
    Vec3d center{};     ///< relative to the box's centre, in diagonals
    int width = 512, height = 512;
    bool is_transparent = false;  ///< RGBA without background instead of RGB
    Box box{};                    ///< what is looked at; empty = the box of what is drawn
};

/// Points as EWA splats [Zwicker01]: what lies within a disc of their radius is covered; the front
/// sheet's Gaussians there, normalised, give the colour (grey shading by the normal where the cloud
/// has none). Standard deviations are those of the texture stage where the cloud has areas.
/// Gaussian splats are composited from front to back instead [Kerbl23, eq. 3]; what they cover by
/// half or more is covered. Without colours they are grey.
Image render_points(const PointCloud& cloud, const View& view = {}, const Context& context = {});
/// The mesh with its texture.
Image render_textured(const TexturedMesh& model, const View& view = {},
                      const Context& context = {});
/// The mesh, shaded by its face normals; with `wires`, the triangles' edges drawn on top.
Image render_mesh(const Mesh& mesh, bool wires, const View& view = {}, const Context& context = {});
/// Pictures side by side, rows of `columns`. Throws Error{kUnsupported} unless all have 3 channels,
/// or all 4.
Image contact_sheet(const std::vector<Image>& pictures, int columns);

}  // namespace pointbake
