#include "pointbake/report.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace pointbake {
namespace {

using Json = nlohmann::ordered_json;

/// File names and notes need not be UTF-8; JSON has to be.
std::string dumped(const Json& json) {
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

Json to_json(const Quantiles& q) {
    return {{"min", q.min}, {"p05", q.p05}, {"p25", q.p25}, {"median", q.median},
            {"p75", q.p75}, {"p95", q.p95}, {"p99", q.p99}, {"max", q.max}};
}

Json to_json(const DistanceStats& d) { return {{"mean", d.mean}, {"rms", d.rms}, {"max", d.max}}; }

Json to_json(Vec3d v) { return Json::array({v.x, v.y, v.z}); }

/// Null for what is not known.
Json to_json(const Frame& f) {
    const auto text = [](const std::string& s) { return s.empty() ? Json() : Json(s); };
    return {{"up", f.up == UpAxis::kAuto ? Json() : Json(to_word(f.up))},
            {"metres_per_unit", f.metres_per_unit == 0.0 ? Json() : Json(f.metres_per_unit)},
            {"unit", text(f.unit)},
            {"height_unit", text(f.height_unit)},
            {"crs",
             {{"name", text(f.crs.name)},
              {"epsg", f.crs.epsg == 0 ? Json() : Json(f.crs.epsg)},
              {"vertical", text(f.crs.vertical)},
              {"is_geographic", f.crs.is_geographic},
              {"wkt", text(f.crs.wkt)}}}};
}

/// The first few.
Json scanner_list(const std::vector<Vec3d>& scanners) {
    constexpr std::size_t kShown = 100;
    Json list = Json::array();
    for (std::size_t i = 0; i < std::min(scanners.size(), kShown); ++i)
        list.push_back(to_json(scanners[i]));
    return list;
}

Json to_json(const LoadReport& r) {
    return {{"format", r.format},
            {"rows", r.num_rows},
            {"points", r.num_kept},
            {"defects",
             {{"non_finite", r.num_non_finite},
              {"left_out", r.num_left_out},
              {"merged", r.num_merged},
              {"zero_normals", r.num_zero_normals},
              {"bad_faces", r.num_bad_faces}}},
            {"scanners", {{"count", r.scanners.size()}, {"positions", scanner_list(r.scanners)}}},
            {"notes", r.notes}};
}

Json to_json(const CleanReport& r) {
    return {{"outliers", r.num_outliers},
            {"floating_points", r.num_floating},
            {"floating_pieces", r.num_floating_pieces},
            {"cropped", r.num_cropped},
            {"subsampled", r.num_subsampled}};
}

Json to_json(const AttributesReport& r) {
    return {{"median_spacing", r.median_spacing},
            {"estimated_normals", r.num_estimated_normals},
            {"invalid_normals", r.num_invalid_normals},
            {"flipped_normals", r.num_flipped_normals},
            {"oriented_by_surface", r.oriented_by_surface}};
}

Json to_json(const ReconstructReport& r) {
    return {{"surface", to_word(r.surface)},
            {"method", to_word(r.method)},
            {"reason", r.reason},
            {"vertices", r.num_vertices},
            {"triangles", r.num_triangles},
            {"components", r.num_components},
            {"boundary_loops", r.num_boundary_loops},
            {"flat_points", r.num_flat},
            {"poor_points", r.num_poor},
            {"label_conflicts", r.num_conflicts},
            {"turned_pieces", r.num_turned_pieces},
            {"holes_filled", r.num_holes_filled},
            {"thinned_points", r.num_thinned},
            {"left_out_points", r.num_left_out},
            {"unused_points", r.num_unused},
            {"splat_points", r.num_splat_points},
            {"split_vertices", r.num_split_vertices},
            {"added_area_fraction", r.added_area_fraction}};
}

Json to_json(const SimplifyReport& r) {
    return {{"bound", r.bound},
            {"bound_met", r.bound_met},
            {"points_to_mesh", to_json(r.points_to_mesh)},
            {"mesh_to_surface", to_json(r.mesh_to_surface)},
            {"triangles_before", r.num_triangles_before},
            {"triangles", r.num_triangles},
            {"vertices", r.num_vertices},
            {"parts_left_out", r.num_parts_removed},
            {"points_off_surface", r.num_off_surface},
            {"collapses",
             {{"done", r.num_collapses},
              {"rejected_by_bound", r.num_rejected_by_bound},
              {"rejected_by_topology", r.num_rejected_by_topology},
              {"rejected_by_shape", r.num_rejected_by_shape}}}};
}

Json to_json(const TextureReport& r) {
    Json densities = Json::array();
    for (const TextureReport::Density& d : r.densities)
        densities.push_back({{"texels_per_unit", d.texels_per_unit}, {"area", d.area_share}});
    return {{"bound", r.bound},
            {"bound_met", r.bound_met},
            {"error_to_splats",
             {{"mean", r.error_mean},
              {"rms", r.error_rms},
              {"p99", r.error_p99},
              {"max", r.error_max}}},
            {"error_to_points", {{"rms", r.raw_rms}, {"p99", r.raw_p99}}},
            {"capped_triangles",
             {{"total", r.capped.total()},
              {"by_spacing", r.capped.by_spacing},
              {"by_count", r.capped.by_count},
              {"by_size", r.capped.by_size},
              {"by_budget", r.capped.by_budget},
              {"by_layout", r.capped.by_layout},
              {"by_format", r.capped.by_format}}},
            {"sharpening_rounds", r.sharpening_rounds},
            {"hidden_points", r.num_hidden_points},
            {"patches", r.num_patches},
            {"needed_texels", r.num_needed_texels},
            {"payload_texels", r.payload_texels},
            {"uncovered_texels", r.num_uncovered_texels},
            {"unseen_vertices", r.num_unseen_vertices},
            {"largest_stretch", r.largest_stretch},
            {"densities", densities}};
}

Json to_json(const DenoiseReport& r) {
    Json json = {{"noise_in_spacings", r.is_measured ? Json(r.noise) : Json()},
                 {"done", r.is_done},
                 {"relief", r.is_relief}};
    if (r.is_done)
        json.update(
            {{"noise_left", r.noise_left}, {"shift_rms", r.shift_rms}, {"shift_max", r.shift_max}});
    return json;
}

Json to_json(const AtlasReport& r) {
    Json pages = Json::array();
    for (const PageSize& page : r.pages) pages.push_back({page.width, page.height});
    return {{"pages", pages}, {"texels", r.num_texels}, {"fill", r.fill}, {"payload", r.payload}};
}

Json to_json(const WriteReport& r) {
    Json files = Json::array();
    for (const std::filesystem::path& file : r.files) files.push_back(file.string());
    return {{"files", files},
            {"bytes", r.num_bytes},
            {"vertices", r.num_vertices},
            {"draw_calls", r.num_draw_calls},
            {"frame", to_json(r.frame)},
            {"global_shift", to_json(r.global_shift)},
            {"prj", r.prj.empty() ? Json() : Json(r.prj.string())}};
}

Json timings(const RunReport& r) {
    Json stages = Json::array();
    for (const StageTime& time : r.convert.times)
        stages.push_back({{"stage", to_word(time.stage)},
                          {"seconds", time.seconds},
                          {"peak_bytes", time.peak_bytes}});
    return {{"threads", r.threads},
            {"stages", stages},
            {"seconds", r.seconds},
            {"peak_bytes", r.peak_bytes}};
}

}  // namespace

std::string_view version() { return POINTBAKE_VERSION; }

void add_distributions(RunReport& report, const SimplifyResult& light) {
    std::vector<double> distances;
    std::vector<double> counts(light.mesh.triangles.size(), 0.0);
    for (std::size_t i = 0; i < light.point_triangles.size(); ++i) {
        if (light.point_triangles[i] == kInvalidIndex) continue;
        distances.push_back(static_cast<double>(light.point_distances[i]));
        counts[light.point_triangles[i]] += 1.0;
    }
    report.point_distances = quantiles(std::move(distances));
    report.points_per_triangle = quantiles(std::move(counts));
}

std::string report_json(const RunReport& r) {
    Json json = {{"program", "pointbake"},
                 {"version", version()},
                 {"input", {{"file", r.input}}},
                 {"output", r.output},
                 {"options", Json::parse(r.options)}};
    json["input"].update(to_json(r.load));
    json["input"]["frame"] = to_json(r.frame);
    json["last_stage"] = to_word(r.last_stage);
    if (r.last_stage >= Stage::kAttributes) {
        json["clean"] = to_json(r.convert.clean);
        json["denoise"] = to_json(r.convert.denoise);
        json["attributes"] = to_json(r.convert.attributes);
    }
    if (r.last_stage >= Stage::kReconstruct) json["reconstruct"] = to_json(r.convert.reconstruct);
    if (r.last_stage >= Stage::kSimplify) {
        json["simplify"] = to_json(r.convert.simplify);
        json["simplify"]["point_distances"] = to_json(r.point_distances);
        json["simplify"]["points_per_triangle"] = to_json(r.points_per_triangle);
    }
    if (r.last_stage >= Stage::kTexture) {
        json["texture"] = to_json(r.convert.texture);
        json["atlas"] = to_json(r.convert.atlas);
    }
    json["write"] = to_json(r.write);
    json["warnings"] = r.convert.warnings;
    json["timings"] = timings(r);
    return dumped(json);
}

std::string info_json(std::string_view file, const LoadReport& load, const CloudSummary& cloud,
                      std::uint64_t num_faces) {
    Json attributes = Json::array();
    for (const AttributeRange& range : cloud.attributes)
        attributes.push_back({{"name", range.name},
                              {"unit", range.unit},
                              {"known", range.num_known},
                              {"low", range.low},
                              {"high", range.high}});
    Json json = {{"file", file}};
    json.update(to_json(load));
    json["faces"] = num_faces;
    json["frame"] = to_json(cloud.frame);
    json["origin"] = to_json(cloud.box.low);
    json["box"] = {{"low", to_json(cloud.box.low)}, {"high", to_json(cloud.box.high)}};
    json["extent"] = to_json(cloud.box.extent());
    json["diagonal"] = cloud.box.diagonal();
    json["spacing"] = to_json(cloud.spacing);
    json["attributes"] = attributes;
    json["predicted_memory"] = predicted_memory(cloud.num_points, cloud.are_splats);
    return dumped(json);
}

}  // namespace pointbake
