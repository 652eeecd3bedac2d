// The whole pipeline, stage after stage. Start reading here.
#include "pointbake/convert.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <utility>

#include "bake.h"
#include "core/adjacency.h"
#include "core/memory.h"
#include "core/message.h"
#include "core/parallel.h"
#include "pointbake/splats.h"
#include "write/encode_image.h"

namespace pointbake {
namespace {

// Times each stage and hands its value to the observer.
class StageRunner {
 public:
    StageRunner(ConvertResult& result, const ConvertOptions& options, const StageObserver& observer,
                const Context& context)
        : result_(result), options_(options), observer_(observer), context_(context) {}

    /// Runs one stage; false when the pipeline ends after it.
    template <class Body>
    bool run(Stage stage, Body&& body) {
        const std::string_view name = to_word(stage);
        report_progress(context_, name, 0.0);
        const auto start = std::chrono::steady_clock::now();
        body();
        check_cancelled(context_);
        const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
        result_.report.times.push_back({stage, seconds.count(), peak_memory_bytes()});
        report_progress(context_, name, 1.0);
        log(context_, LogLevel::kInfo, "{}: {:.2f} s", name, seconds.count());
        if (observer_) observer_(stage, result_);
        return options_.stop_after != stage;
    }

 private:
    ConvertResult& result_;
    const ConvertOptions& options_;
    const StageObserver& observer_;
    const Context& context_;
};

void warn(ConvertResult& result, const Context& context, std::string message) {
    log(context, LogLevel::kWarning, "{}", message);
    result.report.warnings.push_back(std::move(message));
}

// Colour from a channel called intensity where there is none of its own, on the range that its
// finite values span; NaN is black.
bool intensity_to_color(PointCloud& cloud) {
    for (const Channel& channel : cloud.channels) {
        if (channel.kind != ChannelKind::kScalar || channel.num_components != 1) continue;
        if (channel.name.find("ntensity") == std::string::npos) continue;
        float low = HUGE_VALF, high = -HUGE_VALF;
        for (const float v : channel.data)
            if (std::isfinite(v)) low = std::min(low, v), high = std::max(high, v);
        const float range = high - low;
        if (!(range > 0.0F && std::isfinite(range))) continue;
        cloud.colors.resize(cloud.size());
        for (std::size_t i = 0; i < cloud.size(); ++i) {
            const float v = std::isnan(channel.data[i]) ? low : channel.data[i];
            const auto grey =
                static_cast<std::uint16_t>(std::clamp((v - low) / range, 0.0F, 1.0F) * 65535.0F);
            cloud.colors[i] = {grey, grey, grey};
        }
        return true;
    }
    return false;
}

void settle_colors(ConvertResult& result, bool has_vertex_colors, const Context& context) {
    if (!result.cloud.colors.empty()) return;
    if (intensity_to_color(result.cloud)) {
        warn(result, context, "the points carry no colours: their intensity is shown as grey");
    } else {
        warn(result, context,
             fmt::format("the points carry no colours: {}", has_vertex_colors
                                                                ? "the mesh has none, either"
                                                                : "a normal map is baked instead"));
    }
}

// Readings of [Wicke05] that its text leaves open.
void tell_paper_readings(const Context& context) {
    log(context, LogLevel::kInfo,
        "--paper: one triangle per patch, orthographic projection, kernel exp(-|u/r|^2) cut at its "
        "radius (the spacing), "
        "screen filter of variance 0.5; no sharpening");
    log(context, LogLevel::kInfo,
        "--paper: eq. (1) literally, over the points whose centre lies in the triangle, against "
        "--texture-error times "
        "its area; d_min of eq. (2) is the 5 % quantile of the spacings; Appendix A packing with "
        "rows "
        "kept open; a point is hidden where two others lie over it beyond a gap of 2.5 spacings");
}

// What may help where the surface leaves out most of the points.
std::string other_ways(const ConvertOptions& options) {
    std::string ways = options.denoise.denoise == Denoise::kOff ? "--denoise on, " : "";
    ways += "another --surface or --method";
    if (options.simplify.geometry_error)
        ways += fmt::format(", a larger --geometry-error than {}",
                            to_string(*options.simplify.geometry_error));
    return ways;
}

// A reconstructed surface without most of its points is none of theirs; a budget may leave out
// parts.
void check_surface(const ConvertResult& result, const ConvertOptions& options) {
    const SimplifyReport& report = result.light.report;
    if (report.num_parts_removed > 0 || 2 * report.num_off_surface <= result.cloud.size()) return;
    fail(ErrorCode::kDegenerate,
         "the surface found leaves out {} of {} points, which lie farther from it than the bound; "
         "try {}",
         report.num_off_surface, result.cloud.size(), other_ways(options));
}

// Points that the surface leaves out are told of when they are many; when they are all, nothing is
// left to make.
void check_off_surface(ConvertResult& result, bool is_given, const Context& context) {
    constexpr double kMany = 0.02, kFar = 0.02;
    const SimplifyReport& report = result.light.report;
    const auto n = static_cast<double>(result.cloud.size());
    const auto share = static_cast<double>(report.num_off_surface) / n;
    constexpr std::string_view kHint = "; are mesh and points in the same place and unit?";
    if (is_given && report.num_off_surface == result.cloud.size())
        fail(ErrorCode::kEmpty, "no point lies near the mesh{}", kHint);
    result.report.leaves_out_many = share > kMany;
    if (share > kMany)
        warn(result, context,
             fmt::format("{} of {} points ({:.1f} %) lie farther from the surface than the bound "
                         "and are left out{}",
                         report.num_off_surface, result.cloud.size(), 100.0 * share,
                         is_given ? kHint : ""));
    Box box;
    for (const Vec3d& p : result.light.mesh.positions) box.extend(p);
    if (is_given && report.points_to_mesh.mean > kFar * box.diagonal())
        warn(result, context,
             fmt::format("the points lie {:.3g} from the mesh in the mean{}",
                         report.points_to_mesh.mean, kHint));
}

// A surface with a border is seen from both sides.
bool has_border(const Mesh& mesh) {
    return topology(mesh.positions.size(), mesh.triangles).num_boundary_edges > 0;
}

// The mesh that comes from a file instead of from reconstruction.
ReconstructResult given_mesh(ConvertInput& input) {
    ReconstructResult out;
    out.report.surface = Surface::kGiven;
    if (input.mesh) {
        out.surface.mesh = std::move(input.mesh->mesh);
        out.report.reason = "the mesh that was given";
    } else {
        if (!input.file_mesh) {
            fail(ErrorCode::kInvalidOption,
                 "--surface given: the input holds points only, no faces");
        }
        out.surface.mesh = std::move(*input.file_mesh);
        out.surface.vertex_points.resize(out.surface.mesh.positions.size());
        for (Index v = 0; v < out.surface.vertex_points.size(); ++v)
            out.surface.vertex_points[v] = v;
        out.report.reason = "faces of the input file";
    }
    out.report.num_vertices = static_cast<Index>(out.surface.mesh.positions.size());
    out.report.num_triangles = static_cast<Index>(out.surface.mesh.triangles.size());
    return out;
}

// The splats become points of a surface around them, as if the file held it. Returns its grid's
// step.
double go_around(PointCloud& cloud, ConvertInput& input, ConvertResult& result,
                 const Context& context) {
    SplatSurface around = splat_surface(cloud, context);
    result.splats = std::exchange(cloud, std::move(around.cloud));
    input.file_mesh = std::move(around.mesh);
    if (around.step > around.wanted_step)
        warn(result, context,
             fmt::format("the splats extend too far for a grid of {:.3g}: it is of {:.3g}, and "
                         "details are lost; --crop what lies far off",
                         around.wanted_step, around.step));
    return around.step;
}

void tell_of_splats(const ConvertResult& result, double step, ReconstructReport& report) {
    const Mesh& mesh = result.dense.mesh;
    const Topology found = topology(mesh.positions.size(), mesh.triangles);
    report.surface = Surface::kWatertight;
    report.method = Method::kOpacity;
    report.num_components = found.num_components;
    report.num_splat_points = static_cast<Index>(result.cloud.size());
    report.reason = fmt::format("around Gaussian splats, on a grid of {:.3g}; {} points of it",
                                step, result.cloud.size());
}

// Given normals that contradict each other are worth nothing.
void estimate_unsure_normals(ConvertResult& result, const std::vector<Index>& unsure,
                             const AttributesOptions& options, const Context& context) {
    if (unsure.empty()) return;
    warn(result, context,
         fmt::format("the normals of {} points contradict each other: estimated anew",
                     unsure.size()));
    for (const Index i : unsure) {
        result.cloud.normals[i] = {};
        result.cloud.given_normals[i] = 0;
    }
    result.cloud = estimate_attributes(std::move(result.cloud), options, context).cloud;
}

bool has_given_surface(const ConvertInput& input, const ConvertOptions& options) {
    return input.mesh || options.reconstruct.surface == Surface::kGiven;
}

// Vertices of a mesh are where they should be.
DenoiseOptions denoising_for(const ConvertInput& input, const ConvertOptions& options) {
    DenoiseOptions out = options.denoise;
    if (out.denoise == Denoise::kAuto && input.file_mesh) out.denoise = Denoise::kOff;
    return out;
}

// Thinning takes a small share of the geometry bound.
ReconstructOptions reconstruction_for(const ConvertOptions& options, const PointCloud& cloud) {
    constexpr double kOfBound = 0.1;
    ReconstructOptions out = options.reconstruct;
    Box box;
    for (const Vec3d& p : cloud.positions) box.extend(p);
    if (const auto bound = bound_of(options.simplify))
        out.most_thinning = kOfBound * bound->in_units(box.diagonal());
    return out;
}

// Oriented without a surface, as the implicit method wants them.
void orient_normals(ConvertResult& result, const ConvertOptions& options, const Context& context) {
    result.cloud =
        refine_attributes(std::move(result.cloud), {}, options.attributes, context).cloud;
}

// Where Tight Cocone would enclose too little the implicit method goes around the points.
ReconstructResult reconstructed(ConvertResult& result, const ConvertOptions& options,
                                const Context& context) {
    ReconstructOptions how = reconstruction_for(options, result.cloud);
    if (needs_normals(how)) orient_normals(result, options, context);
    double lost = 0.0;
    try {
        return reconstruct(result.cloud, how, context);
    } catch (const TooLittleEnclosed& error) {
        lost = error.lost_area_fraction;
    }
    orient_normals(result, options, context);
    how.method = Method::kImplicit;
    ReconstructResult closed = reconstruct(result.cloud, how, context);
    closed.report.reason +=
        fmt::format("; Tight Cocone would lose {:.1f} % of what was found", 100 * lost);
    return closed;
}

// Where the surface is given, what is asked for beside it would not be done.
void check_given(const ConvertInput& input, const ConvertOptions& options) {
    const auto refuse = [&](std::string_view option) {
        fail(ErrorCode::kInvalidOption, "{} does not go with {}: nothing is reconstructed", option,
             input.mesh ? "--mesh" : "--surface given");
    };
    const ReconstructOptions& asked = options.reconstruct;
    if (asked.surface != Surface::kAuto && asked.surface != Surface::kGiven)
        refuse(fmt::format("--surface {}", to_word(asked.surface)));
    if (asked.method != Method::kAuto) refuse(fmt::format("--method {}", to_word(asked.method)));
    if (asked.thin != Thin::kAuto) refuse(fmt::format("--thin {}", to_word(asked.thin)));
    if (asked.fill_holes) refuse("--fill-holes");
    if (options.denoise.denoise == Denoise::kOn) refuse("--denoise on");
    if (!input.mesh && (options.clean.crop || options.clean.subsample))
        fail(ErrorCode::kInvalidOption,
             "--crop and --subsample do not go with --surface given: the faces need their points");
}

// Of splats, what is asked of a surface through points would not be done.
void check_opacity(const ConvertOptions& options) {
    const auto refuse = [](std::string_view option) {
        fail(ErrorCode::kInvalidOption,
             "{} does not go with --method opacity: no points are joined", option);
    };
    if (options.reconstruct.thin != Thin::kAuto) refuse("--thin off");
    if (options.reconstruct.fill_holes) refuse("--fill-holes");
    if (options.denoise.denoise == Denoise::kOn) refuse("--denoise on");
}

Length in_units(Length length, double metres_per_unit) {
    return length.kind == Length::Kind::kMetres ? units(length.value / metres_per_unit) : length;
}

// All lengths of a struct of options.
template <class Options>
void settle_lengths(Options& options, double metres_per_unit) {
    Options::describe([&](std::string_view, auto member, std::string_view) {
        using T = std::remove_cvref_t<decltype(options.*member)>;
        auto& value = options.*member;
        if constexpr (std::is_same_v<T, Length>) value = in_units(value, metres_per_unit);
        if constexpr (std::is_same_v<T, std::optional<Length>>)
            if (value) value = in_units(*value, metres_per_unit);
    });
}

void check_images(const ConvertOptions& options) {
    validate(options.images);
    const int longest = longest_side(options.images.format);
    if (options.atlas.page_size > longest)
        fail(ErrorCode::kInvalidOption, "page-size is {}: {} holds at most {}",
             options.atlas.page_size, to_word(options.images.format), longest);
}

// --texels 0: there is no texture.
bool colors_vertices(const ConvertOptions& options) { return options.texture.texels == 0; }

// Without a texture, what is asked of it would not be done.
void check_vertex_colors(const ConvertOptions& options) {
    if (!colors_vertices(options)) return;
    const auto refuse = [](std::string_view option) {
        fail(ErrorCode::kInvalidOption, "--texels 0 makes no texture: {} does not go with it",
             option);
    };
    if (options.texture.texture_error) refuse("--texture-error");
    if (options.texture.keep_uvs) refuse("--keep-uvs");
    if (options.texture.paper) refuse("--paper");
    if (options.texture.debug_maps) refuse("--debug-maps");
}

// The light mesh with the colours of its vertices; without colours of the points it has none.
void color_mesh(ConvertResult& result, const ConvertOptions& options, const Context& context) {
    result.model.mesh = result.light.mesh;
    result.model.materials = {Material{.name = "surface"}};
    TextureReport& report = result.report.texture;
    report.bound = HUGE_VAL;
    if (result.cloud.colors.empty()) return;
    VertexColors colors = color_vertices(result.light.mesh, result.cloud,
                                         result.light.point_triangles, options.texture, context);
    result.model.mesh.colors = std::move(colors.colors);
    report.raw_rms = colors.rms;
    report.raw_p99 = colors.p99;
    report.num_unseen_vertices = colors.num_unseen;
}

void bake_pages(ConvertResult& result, const std::optional<GivenLayout>& layout,
                const ConvertOptions& options, const Context& context) {
    BakeResult baked = bake_texture(result.light.mesh, result.cloud, result.light.point_triangles,
                                    layout, options, context);
    for (std::string& warning : baked.warnings) warn(result, context, std::move(warning));
    result.model = std::move(baked.model);
    result.debug_maps = std::move(baked.debug_maps);
    result.report.texture = baked.texture;
    result.report.atlas = std::move(baked.atlas);
}

}  // namespace

ConvertOptions in_cloud_units(ConvertOptions options, const Frame& frame) {
    if (frame.metres_per_unit == 0.0) return options;
    settle_lengths(options.clean, frame.metres_per_unit);
    settle_lengths(options.reconstruct, frame.metres_per_unit);
    settle_lengths(options.simplify, frame.metres_per_unit);
    return options;
}

void validate(const ConvertOptions& options) {
    if (options.texture.texture_error && !(*options.texture.texture_error >= 0.0))
        fail(ErrorCode::kInvalidOption, "texture-error is {}: 0 or more is accepted",
             *options.texture.texture_error);
    constexpr int kMostMips = 6;
    if (options.texture.mips < 0 || options.texture.mips > kMostMips)
        fail(ErrorCode::kInvalidOption, "mips is {}: 0 to {} are accepted", options.texture.mips,
             kMostMips);
    validate(options.clean);
    validate(options.reconstruct);
    if (options.reconstruct.method == Method::kOpacity) check_opacity(options);
    validate(options.simplify);
    // Refuses sides and budgets that no page can have.
    constexpr std::uint64_t kSmallestPage = 64 * 64;
    if (!colors_vertices(options))
        budget_pages(static_cast<std::int64_t>(options.texture.texels.value_or(kSmallestPage)),
                     options.atlas);
    check_images(options);
    check_vertex_colors(options);
    if (options.simplify.triangles > 0 && (options.simplify.keep_mesh || options.texture.keep_uvs))
        fail(ErrorCode::kInvalidOption,
             "--triangles does not go with a mesh that is kept (--keep-mesh, --keep-uvs)");
    if (options.texture.keep_uvs && options.texture.paper)
        fail(ErrorCode::kInvalidOption,
             "--paper lays out triangles of its own: it does not go with --keep-uvs");
}

bool goes_around_splats(const PointCloud& cloud, const ConvertOptions& options) {
    const ReconstructOptions& asked = options.reconstruct;
    if (!cloud.are_splats) return false;
    if (asked.method != Method::kAuto) return asked.method == Method::kOpacity;
    return (asked.surface == Surface::kAuto || asked.surface == Surface::kWatertight) &&
           asked.thin == Thin::kAuto && !asked.fill_holes &&
           options.denoise.denoise != Denoise::kOn;
}

CleanOptions cleaning_for(const ConvertInput& input, const ConvertOptions& options) {
    CleanOptions cleaning = options.clean;
    if (!has_given_surface(input, options)) return cleaning;
    check_given(input, options);
    cleaning.outliers = cleaning.floaters = Unwanted::kKeep;
    return cleaning;
}

ConvertResult convert(ConvertInput input, const ConvertOptions& given,
                      const StageObserver& observer, const Context& context) {
    const ConvertOptions options = in_cloud_units(given, input.cloud.frame);
    ConvertResult result;
    StageRunner stages(result, options, observer, context);
    validate(options);
    std::optional<GivenLayout> layout;
    if (options.texture.keep_uvs) layout = given_layout(input.mesh);
    bool is_given = has_given_surface(input, options);
    std::optional<double> splat_step;

    if (!is_given && input.file_mesh)
        result.report.num_unused_faces = input.file_mesh->triangles.size();
    if (options.texture.paper) tell_paper_readings(context);
    if (!stages.run(Stage::kAttributes, [&] {
            CleanResult cleaned =
                clean(std::move(input.cloud), cleaning_for(input, options), context);
            result.report.clean = cleaned.report;
            if (!is_given && goes_around_splats(cleaned.cloud, options)) {
                splat_step = go_around(cleaned.cloud, input, result, context);
                is_given = true;
            }
            // A surface that is given is not second-guessed.
            DenoiseResult denoised = is_given ? DenoiseResult{std::move(cleaned.cloud), {}}
                                              : denoise(std::move(cleaned.cloud),
                                                        denoising_for(input, options), context);
            result.report.denoise = denoised.report;
            AttributesResult attributes =
                estimate_attributes(std::move(denoised.cloud), options.attributes, context);
            result.cloud = std::move(attributes.cloud);
            result.report.attributes = attributes.report;
        })) {
        return result;
    }
    if (!stages.run(Stage::kReconstruct, [&] {
            ReconstructResult surface =
                is_given ? given_mesh(input) : reconstructed(result, options, context);
            result.dense = std::move(surface.surface);
            result.report.reconstruct = surface.report;
            if (splat_step) tell_of_splats(result, *splat_step, result.report.reconstruct);
            estimate_unsure_normals(result, surface.unsure_normals, options.attributes, context);
            AttributesResult refined = refine_attributes(std::move(result.cloud), result.dense,
                                                         options.attributes, context);
            result.cloud = std::move(refined.cloud);
            result.report.attributes = refined.report;
        })) {
        return result;
    }
    if (!stages.run(Stage::kSimplify, [&] {
            SimplifyOptions simplifying = options.simplify;
            simplifying.keep_mesh = simplifying.keep_mesh || layout;
            result.light = simplify(result.dense, result.cloud, simplifying, context);
            result.report.simplify = result.light.report;
            if (!is_given) check_surface(result, options);
            check_off_surface(result, is_given && !splat_step, context);
        })) {
        return result;
    }
    stages.run(Stage::kTexture, [&] {
        settle_colors(result, colors_vertices(options), context);
        if (colors_vertices(options))
            color_mesh(result, options, context);
        else
            bake_pages(result, layout, options, context);
        result.model.frame = result.cloud.frame;
        const bool open = has_border(result.model.mesh);
        for (Material& material : result.model.materials) material.is_double_sided = open;
    });
    return result;
}

}  // namespace pointbake
