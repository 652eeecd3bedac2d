// The whole pipeline: points in, textured mesh out.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "pointbake/atlas.h"
#include "pointbake/attributes.h"
#include "pointbake/clean.h"
#include "pointbake/denoise.h"
#include "pointbake/load.h"
#include "pointbake/reconstruct.h"
#include "pointbake/simplify.h"
#include "pointbake/texture.h"
#include "pointbake/types.h"
#include "pointbake/write.h"

namespace pointbake {

enum class Stage { kLoad, kAttributes, kReconstruct, kSimplify, kTexture, kWrite };
template <>
struct EnumWords<Stage> {
    static constexpr std::string_view words[] = {"load",     "attributes", "reconstruct",
                                                 "simplify", "texture",    "write"};
};

struct ConvertOptions {
    CleanOptions clean;
    DenoiseOptions denoise;
    AttributesOptions attributes;
    ReconstructOptions reconstruct;
    SimplifyOptions simplify;
    TextureOptions texture;
    AtlasOptions atlas;
    ImageOptions images;
    Stage stop_after = Stage::kWrite;
};

struct StageTime {
    Stage stage;
    double seconds = 0.0;
    std::uint64_t peak_bytes = 0;  ///< of the process so far
};

struct AtlasReport {
    std::vector<PageSize> pages;
    std::int64_t num_texels = 0;  ///< sum over the pages of one map
    double fill = 0.0;            ///< texels that patches need / texels
    double payload = 0.0;         ///< surface texels / texels
};

struct ConvertReport {
    CleanReport clean;
    DenoiseReport denoise;
    AttributesReport attributes;
    ReconstructReport reconstruct;
    SimplifyReport simplify;
    TextureReport texture;
    AtlasReport atlas;
    std::uint64_t num_unused_faces = 0;  ///< of the points' file: its points are reconstructed
    bool leaves_out_many = false;        ///< more than 2 % of the points are off the surface
    std::vector<StageTime> times;
    std::vector<std::string> warnings;
};

struct ConvertInput {
    PointCloud cloud;               ///< as load_cloud hands it on
    std::optional<Mesh> file_mesh;  ///< faces of the same file: used with --surface given (and told
                                    ///< about otherwise)
    std::optional<TexturedMesh> mesh;  ///< --mesh: reconstruct is skipped
};

/// Every stage's value; what was not reached stays empty.
struct ConvertResult {
    PointCloud cloud;
    PointCloud splats;  ///< with a surface around splats: they; the cloud is then the points of it
    DenseMesh dense;
    SimplifyResult light;
    TexturedMesh model;
    std::vector<DebugMap> debug_maps;  ///< with options.texture.debug_maps
    ConvertReport report;
};

/// Called after each stage with all values so far (for --work-dir).
using StageObserver = std::function<void(Stage, const ConvertResult&)>;

/// Throws Error{kInvalidOption} for options that contradict each other.
void validate(const ConvertOptions& options);

/// The same options with lengths in metres as lengths in the cloud's units.
ConvertOptions in_cloud_units(ConvertOptions options, const Frame& frame);

/// How convert cleans this input. Where the surface is given, it says what belongs to it: outliers
/// and floating pieces are not looked for. Throws Error{kInvalidOption} where the faces of the same
/// file would lose points, and for options of a reconstruction that is not done.
CleanOptions cleaning_for(const ConvertInput& input, const ConvertOptions& options);

/// Whether a surface is laid around the cloud's Gaussian splats instead of one through its points:
/// if there are splats, and nothing else is asked for.
bool goes_around_splats(const PointCloud& cloud, const ConvertOptions& options);

/// Lengths in metres follow the cloud's frame, which goes on to the model. Throws Error as the
/// stages do, and Error{kDegenerate} for a reconstructed surface that leaves
/// out more than half of the points.
ConvertResult convert(ConvertInput input, const ConvertOptions& given = {},
                      const StageObserver& observer = {}, const Context& context = {});

}  // namespace pointbake
