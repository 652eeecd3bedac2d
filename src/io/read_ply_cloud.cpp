#include <algorithm>

#include "core/message.h"
#include "core/parallel.h"
#include "io/order.h"
#include "io/ply_faces.h"
#include "io/ply_points.h"
#include "io/read_ply.h"

namespace pointbake {
namespace {

/// The vertex element; throws if there is none, or none of its rows.
std::size_t find_points(const PlyHeader& header, const std::string& path) {
    const auto found = header.find("vertex");
    if (!found)
        fail(ErrorCode::kInvalidInput,
             "{}: the header has no element 'vertex': there are no points", path);
    if (header.elements[*found].count == 0)
        fail(ErrorCode::kEmpty, "{}: the file holds 0 points", path);
    return *found;
}

void note_ignored_elements(const PlyHeader& header, std::size_t points,
                           std::optional<std::size_t> faces, LoadReport& report) {
    std::string names;
    for (std::size_t i = 0; i < header.elements.size(); ++i)
        if (i != points && i != faces && header.elements[i].count > 0)
            names += (names.empty() ? "" : ", ") + header.elements[i].name;
    if (!names.empty()) report.notes.push_back("elements ignored: " + names);
}

/// All normals unknown is no normals at all.
void finish_normals(PointCloud& cloud, LoadReport& report) {
    const auto num_zero = std::count(cloud.normals.begin(), cloud.normals.end(), Vec3f{});
    report.num_zero_normals = static_cast<std::uint64_t>(num_zero);
    if (cloud.normals.empty() || report.num_zero_normals < cloud.normals.size()) return;
    cloud.normals.clear();
    report.notes.emplace_back("all normals are zero: ignored");
}

}  // namespace

LoadResult read_ply_cloud(std::span<const std::byte> bytes, const std::filesystem::path& path,
                          const Context& context) {
    const std::string name = path.string();
    const PlyHeader header = read_ply_header(bytes, name);
    const std::size_t points = find_points(header, name);
    const std::optional<std::size_t> faces = find_faces(header);
    const PlyBody body(bytes, header, std::max(points, faces.value_or(0)) + 1, name, context);
    report_progress(context, "load", 0.2);

    LoadResult result;
    LoadReport& report = result.report;
    report.format = fmt::format("PLY {}", to_string(header.format));
    report.num_rows = header.elements[points].count;
    report.notes = header.notes;
    PlyPoints read = read_ply_points(body, header, points, name, context);
    report.notes.insert(report.notes.end(), read.notes.begin(), read.notes.end());
    note_ignored_elements(header, points, faces, report);
    report_progress(context, "load", 0.5);

    OrderedCloud ordered = order_cloud(std::move(read.rows), context);
    result.cloud = std::move(ordered.cloud);
    PointCloud& cloud = result.cloud;
    report.num_kept = cloud.size();
    report.num_non_finite = cloud.dropped.size();
    report.num_merged = cloud.merged.size();
    if (cloud.size() == 0)
        fail(ErrorCode::kEmpty, "{}: none of the {} points has finite coordinates", name,
             report.num_rows);
    finish_normals(cloud, report);
    report_progress(context, "load", 0.9);

    if (faces) {
        PlyFaces found = read_ply_faces(body, header, *faces, ordered.point_of_row, false, context);
        report.num_bad_faces = found.num_bad;
        if (!found.triangles.empty()) {
            result.mesh.emplace();
            result.mesh->positions = cloud.positions;
            result.mesh->triangles = std::move(found.triangles);
        }
    }
    report_progress(context, "load", 1.0);
    return result;
}

}  // namespace pointbake
