// The way back: a textured mesh becomes surfels. For test data, and for whoever has a mesh and
// wants points.
#pragma once

#include "pointbake/context.h"
#include "pointbake/options.h"
#include "pointbake/types.h"

namespace pointbake {

enum class SampleMode { kLdc, kBlue };
template <>
struct EnumWords<SampleMode> {
    static constexpr std::string_view words[] = {"ldc", "blue"};
};

struct SampleOptions {
    SampleMode mode = SampleMode::kLdc;
    std::uint64_t points = 200000;
    bool paint = false;
    template <class Field>
    static void describe(Field&& field) {
        field("mode", &SampleOptions::mode,
              "ldc: layered depth cube, best axis; blue: blue noise by sample elimination");
        field("points", &SampleOptions::points, "about this many points");
        field("paint", &SampleOptions::paint,
              "ignore the mesh's colours and paint it like the demo model");
    }
};

/// Surfels with positions, normals, radii, areas and colours (in whole 8-bit steps: PLY files with
/// more are not read everywhere), ready to convert again. ldc
/// [Pfister00]: one ray grid per triangle along its dominant axis, so every sample stands for
/// exactly spacing^2 / |n_axis|; the areas sum to the surface's within 0.2 % and every surface
/// point is within 0.87 of the spacing (where the axis changes and at borders by added samples,
/// which take half their neighbour's area). blue [Yuksel15]: weighted sample elimination from 5 N
/// random ones. Colours come from the mip level whose texel is at most the spacing; a mesh without
/// any gives points without. Throws Error{kInvalidOption, kInvalidInput}, and Error{kDegenerate}
/// for a mesh without area.
PointCloud sample(const TexturedMesh& mesh, const SampleOptions& options = {},
                  const Context& context = {});

}  // namespace pointbake
