#include "summary.h"

#include <cmath>

#include "frame_lines.h"

namespace pointbake::cli {
namespace {

// What the stage takes where nothing is asked for.
constexpr double kDefaultTextureError = 4.0;

std::string bound_text(double bound) {
    return std::isfinite(bound) ? fmt::format("bound {:.4g}", bound) : "no bound";
}

bool was_reconstructed(const RunReport& r) { return r.convert.reconstruct.method != Method::kAuto; }

/// "4,812 outliers, 37 points of 3 floating pieces"; empty if nothing is dropped.
std::string cleaning_text(const CleanReport& clean) {
    std::vector<std::string> parts;
    if (clean.num_outliers > 0) parts.push_back(counted(clean.num_outliers, "outlier"));
    if (clean.num_floating > 0)
        parts.push_back(fmt::format("{} of {}", counted(clean.num_floating, "point"),
                                    counted(clean.num_floating_pieces, "floating piece")));
    if (clean.num_cropped > 0)
        parts.push_back(counted(clean.num_cropped, "point") + " outside of --crop");
    if (clean.num_subsampled > 0)
        parts.push_back(counted(clean.num_subsampled, "point") + " nearer than --subsample");
    return fmt::format("{}", fmt::join(parts, ", "));
}

std::uint64_t num_points(const RunReport& r) {
    return r.load.num_kept - r.convert.clean.num_dropped();
}

std::string points_text(const RunReport& r) {
    const bool are_splats = r.convert.reconstruct.method == Method::kOpacity;
    return counted(num_points(r), are_splats ? "splat" : "point");
}

std::string noise_text(const DenoiseReport& r) {
    std::string text = fmt::format("noise {:.2g} spacings", r.noise);
    if (r.is_done) text += fmt::format(", taken out down to {:.2g}", r.noise_left);
    if (r.is_relief) text += ", which is sharp or thin things: left as it is";
    return text;
}

/// What was chosen, and what was measured of the points for it.
std::string surface_line(const RunReport& r) {
    constexpr double kManyThinned = 0.01;
    const ReconstructReport& found = r.convert.reconstruct;
    if (!was_reconstructed(r))
        return fmt::format("surface {}: {}", to_word(found.surface), found.reason);
    std::string line =
        fmt::format("surface {} by {}: {}; spacing {:.3g}", to_word(found.surface),
                    to_word(found.method), found.reason, r.convert.attributes.median_spacing);
    if (r.convert.denoise.is_measured) line += ", " + noise_text(r.convert.denoise);
    if (found.num_holes_filled > 0)
        line += fmt::format("; {} filled", counted(found.num_holes_filled, "hole"));
    if (found.num_thinned > kManyThinned * static_cast<double>(num_points(r)))
        line += fmt::format("; its shape needs {} of {} points as vertices",
                            num_points(r) - found.num_thinned, num_points(r));
    return line;
}

/// Of a run that ends with the dense mesh.
std::string dense_line(const RunReport& r) {
    const ReconstructReport& found = r.convert.reconstruct;
    std::string line =
        fmt::format("{} -> {}", points_text(r), counted(found.num_triangles, "triangle"));
    if (was_reconstructed(r))
        line += fmt::format(" in {} with {}", counted(found.num_components, "piece"),
                            counted(found.num_boundary_loops, "border"));
    return line;
}

std::string unused_faces_text(std::uint64_t num_faces) {
    return fmt::format(
        "the file has {}, of which only the corners are taken: --surface given would use {}, "
        "pointbake "
        "sample makes points of {}",
        counted(num_faces, "face"), num_faces == 1 ? "it" : "them", num_faces == 1 ? "it" : "them");
}

std::string geometry_line(const RunReport& r) {
    const SimplifyReport& simplify = r.convert.simplify;
    std::string line = fmt::format(
        "{} -> {} ({}); farthest point {:.4g}, mean {:.3g}, {}", points_text(r),
        counted(simplify.num_triangles, "triangle"), to_word(r.convert.reconstruct.surface),
        simplify.points_to_mesh.max, simplify.points_to_mesh.mean, bound_text(simplify.bound));
    if (simplify.num_off_surface > 0)
        line += fmt::format("; {} off the surface left out",
                            counted(simplify.num_off_surface, "point"));
    return line;
}

std::string cap_reasons(const CappedCounts& capped) {
    std::string text;
    const auto append = [&](Index count, std::string_view reason) {
        if (count > 0)
            text += fmt::format("{}{} {}", text.empty() ? "" : ", ", grouped(count), reason);
    };
    append(capped.by_spacing, "whose points are too far apart for finer texels");
    append(capped.by_count, "that have 8 texels per point already");
    append(capped.by_size, "as large as --max-patch or --page-size allow");
    append(capped.by_budget, "for want of --texels");
    append(capped.by_layout, "that share texels with others");
    append(capped.by_format,
           "by what --texture-format loses (a higher --texture-quality loses less)");
    return text;
}

std::string pages_text(const std::vector<PageSize>& pages) {
    if (pages.size() != 1) return counted(pages.size(), "page");
    return fmt::format("1 page of {} x {}", pages[0].width, pages[0].height);
}

std::string texture_line(const RunReport& r) {
    const TextureReport& texture = r.convert.texture;
    const AtlasReport& atlas = r.convert.atlas;
    return fmt::format(
        "{} on {}, {:.1f} % filled; texture error {:.3g} RMS to the splats, {:.3g} to the points, "
        "{}",
        counted(static_cast<std::uint64_t>(atlas.num_texels), "texel"), pages_text(atlas.pages),
        100.0 * atlas.fill, texture.error_rms, texture.raw_rms, bound_text(texture.bound));
}

std::string vertex_colors_line(const RunReport& r) {
    return fmt::format("colours of vertices, no texture; {:.3g} RMS to the points",
                       r.convert.texture.raw_rms);
}

std::string file_line(const RunReport& r) {
    return fmt::format("{}, {} in {:.1f} s, peak memory {}",
                       r.output.empty() ? "work directory written" : "wrote " + r.output,
                       bytes_text(r.write.num_bytes), r.seconds, bytes_text(r.peak_bytes));
}

std::string cleaning_plan(const ConvertOptions& convert, const ConvertInput& input,
                          const Context& context) {
    PointCloud points;
    points.positions = input.cloud.positions;
    const CleanOptions options = cleaning_for(input, convert);
    const CleanReport report = clean(std::move(points), options, context).report;
    if (report.num_dropped() == 0) return "nothing to drop";
    return "drop " + cleaning_text(report);
}

std::string simplify_plan(const ConvertOptions& convert, double diagonal) {
    const SimplifyOptions& options = convert.simplify;
    if (options.keep_mesh || convert.texture.keep_uvs) return "kept as it is";
    const std::optional<Length> bound = bound_of(options);
    std::string text =
        bound ? fmt::format("no point farther than {:.4g}", bound->in_units(diagonal)) : "";
    if (options.triangles == 0) return text;
    return fmt::format("{}{}at most {}", text, bound ? ", " : "",
                       counted(options.triangles, "triangle"));
}

std::string texture_plan(const TextureOptions& options) {
    if (options.texels == 0) return "none: colours of vertices";
    const bool has_bound = options.texture_error || !options.texels;
    std::string text = has_bound ? fmt::format("error at most {:.3g} steps",
                                               options.texture_error.value_or(kDefaultTextureError))
                                 : "";
    if (!options.texels) return text;
    return fmt::format("{}{}at most {}", text, has_bound ? ", " : "",
                       counted(*options.texels, "texel"));
}

std::string surface_plan(const Job& job, const ConvertInput& input) {
    if (input.mesh)
        return fmt::format("taken from {}, {}", job.mesh.mesh.string(),
                           counted(input.mesh->mesh.triangles.size(), "triangle"));
    if (goes_around_splats(input.cloud, job.convert)) return "watertight by opacity, around splats";
    const ReconstructOptions& options = job.convert.reconstruct;
    std::string text =
        fmt::format("{}, method {}", to_word(options.surface), to_word(options.method));
    if (input.file_mesh && options.surface != Surface::kGiven)
        text += "; " + unused_faces_text(input.file_mesh->triangles.size());
    return text;
}

std::string vector_text(Vec3d v) { return fmt::format("{:.7g} x {:.7g} x {:.7g}", v.x, v.y, v.z); }

void append_defects(std::vector<std::string>& lines, const LoadReport& load) {
    const auto append = [&](std::uint64_t count, std::string_view noun, std::string_view what) {
        if (count > 0)
            lines.push_back(fmt::format("{:<13} {}{}", "defect", counted(count, noun), what));
    };
    append(load.num_non_finite, "row", " with NaN or infinite coordinates: dropped");
    append(load.num_left_out, "row", " dropped by the reader: see the notes");
    append(load.num_merged, "row", " with the coordinates of another: merged");
    append(load.num_zero_normals, "normal", " of length zero: estimated");
    append(load.num_bad_faces, "face", " with bad or equal corners: dropped");
}

}  // namespace

std::vector<std::string> summary_lines(const RunReport& r) {
    std::vector<std::string> lines;
    if (r.load.num_merged > 0)
        lines.push_back(fmt::format("merged {} with the coordinates of another",
                                    counted(r.load.num_merged, "row")));
    if (!r.load.guess.empty()) lines.push_back(r.load.guess);
    if (r.load.num_left_out > 0)
        lines.push_back(fmt::format("left out {} that are no points (pointbake info tells why)",
                                    counted(r.load.num_left_out, "row")));
    if (r.convert.clean.num_dropped() > 0)
        lines.push_back(fmt::format("cleaned: {} dropped", cleaning_text(r.convert.clean)));
    if (r.last_stage >= Stage::kReconstruct) lines.push_back(surface_line(r));
    if (r.last_stage >= Stage::kReconstruct && r.convert.num_unused_faces > 0)
        lines.push_back(unused_faces_text(r.convert.num_unused_faces));
    if (r.last_stage == Stage::kReconstruct) lines.push_back(dense_line(r));
    if (r.last_stage >= Stage::kSimplify) lines.push_back(geometry_line(r));
    if (r.last_stage >= Stage::kTexture && r.convert.atlas.num_texels > 0)
        lines.push_back(texture_line(r));
    else if (r.last_stage >= Stage::kTexture && r.convert.texture.raw_rms > 0.0)
        lines.push_back(vertex_colors_line(r));
    for (std::string& line : frame_lines(r)) lines.push_back(std::move(line));
    if (!r.write.files.empty() || r.output.empty()) lines.push_back(file_line(r));
    return lines;
}

std::vector<std::string> missed_bounds(const RunReport& r) {
    std::vector<std::string> lines;
    const SimplifyReport& simplify = r.convert.simplify;
    const TextureReport& texture = r.convert.texture;
    if (r.last_stage >= Stage::kSimplify && !simplify.bound_met)
        lines.push_back(fmt::format(
            "the geometry bound of {:.4g} is not met: the farthest point is {:.4g} away",
            simplify.bound, simplify.points_to_mesh.max));
    if (r.last_stage >= Stage::kTexture && !texture.bound_met)
        lines.push_back(fmt::format("the texture bound of {:.4g} is missed on {} of {}: {}",
                                    texture.bound, grouped(texture.capped.total()),
                                    counted(simplify.num_triangles, "triangle"),
                                    cap_reasons(texture.capped)));
    return lines;
}

std::vector<std::string> plan_lines(const Job& job, const ConvertInput& input,
                                    const Context& context) {
    const ConvertOptions convert = in_cloud_units(job.convert, input.cloud.frame);
    Box box;
    for (const Vec3d& p : input.cloud.positions) box.extend(p);
    std::vector<std::string> lines;
    const auto append = [&](std::string_view label, std::string_view text) {
        lines.push_back(fmt::format("{:<13} {}", label, text));
    };
    append("points", fmt::format("{}, {} across", grouped(input.cloud.size()),
                                 fmt::format("{:.6g}", box.diagonal())));
    append("cleaning", cleaning_plan(convert, input, context));
    append("surface", surface_plan(job, input));
    append("simplify", simplify_plan(convert, box.diagonal()));
    append("colours", input.cloud.colors.empty() ? "none in the file" : "in the file");
    append("texture", texture_plan(job.convert.texture));
    append("stop after", to_word(job.stop.stop_after));
    append("output", job.output.empty() ? job.files.work_dir.string() : job.output.string());
    append("memory",
           "up to " + bytes_text(predicted_memory(input.cloud.size(),
                                                  goes_around_splats(input.cloud, job.convert))));
    return lines;
}

std::vector<std::string> info_lines(const LoadReport& load, const CloudSummary& cloud,
                                    std::uint64_t num_faces) {
    std::vector<std::string> lines;
    const auto append = [&](std::string_view label, std::string_view text) {
        lines.push_back(fmt::format("{:<13} {}", label, text));
    };
    append("format", load.format);
    append("rows", grouped(load.num_rows));
    append("points", grouped(load.num_kept));
    if (num_faces > 0) append("faces", grouped(num_faces));
    append("extent", fmt::format("{}, diagonal {:.7g}", vector_text(cloud.box.extent()),
                                 cloud.box.diagonal()));
    append("origin", fmt::format("{:.12g} {:.12g} {:.12g} (lowest corner)", cloud.box.low.x,
                                 cloud.box.low.y, cloud.box.low.z));
    for (const auto& [label, text] : frame_facts(cloud.frame, load)) append(label, text);
    append("spacing", fmt::format("median {:.4g}, 5 % below {:.4g}, 5 % above {:.4g}",
                                  cloud.spacing.median, cloud.spacing.p05, cloud.spacing.p95));
    for (const AttributeRange& range : cloud.attributes)
        append(range.name,
               fmt::format("{:.6g} to {:.6g}{}{}{}", range.low, range.high,
                           range.unit.empty() ? "" : " ", range.unit,
                           range.num_known == cloud.num_points
                               ? ""
                               : fmt::format(", known for {}", counted(range.num_known, "point"))));
    append_defects(lines, load);
    for (const std::string& note : load.notes) append("note", note);
    return lines;
}

}  // namespace pointbake::cli
