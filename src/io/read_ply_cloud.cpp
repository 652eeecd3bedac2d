#include <algorithm>

#include "core/message.h"
#include "core/parallel.h"
#include "io/finish_cloud.h"
#include "io/ply_faces.h"
#include "io/ply_points.h"
#include "io/ply_splats.h"
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

std::string ignored_elements(const PlyHeader& header, std::size_t points,
                             std::optional<std::size_t> faces) {
    std::string names;
    for (std::size_t i = 0; i < header.elements.size(); ++i)
        if (i != points && i != faces && header.elements[i].count > 0 &&
            !(header.elements[i].name == "chunk" && has_packed_splats(header.elements[points])))
            names += (names.empty() ? "" : ", ") + header.elements[i].name;
    return names;
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

    PointRows rows = read_ply_points(body, header, points, name, context);
    rows.notes.insert(rows.notes.begin(), header.notes.begin(), header.notes.end());
    const std::string ignored = ignored_elements(header, points, faces);
    if (!ignored.empty()) rows.notes.push_back("elements ignored: " + ignored);
    report_progress(context, "load", 0.5);

    FinishedCloud finished = finish_cloud(
        std::move(rows), fmt::format("PLY {}", to_string(header.format)), name, context);
    LoadResult& result = finished.result;
    report_progress(context, "load", 0.9);

    if (faces) {
        PlyFaces found =
            read_ply_faces(body, header, *faces, finished.point_of_row, false, context);
        result.report.num_bad_faces = found.num_bad;
        if (!found.triangles.empty()) {
            result.mesh.emplace();
            result.mesh->positions = result.cloud.positions;
            result.mesh->triangles = std::move(found.triangles);
        }
    }
    report_progress(context, "load", 1.0);
    return std::move(result);
}

}  // namespace pointbake
