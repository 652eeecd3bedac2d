#include "io/mesh_vertices.h"

#include <algorithm>

#include "core/message.h"
#include "io/finish_cloud.h"
#include "io/mesh_builder.h"

namespace pointbake {
namespace {

/// The triangles, over the points that their vertices became; those that lost a corner are left
/// out.
Mesh over_points(const Mesh& mesh, const PointCloud& cloud,
                 const std::vector<Index>& point_of_vertex) {
    Mesh out;
    out.positions = cloud.positions;
    out.colors = cloud.colors;
    for (const Triangle& t : mesh.triangles) {
        const Triangle points = {point_of_vertex[t[0]], point_of_vertex[t[1]],
                                 point_of_vertex[t[2]]};
        const bool is_whole = std::ranges::find(points, kInvalidIndex) == points.end();
        const bool is_flat =
            points[0] == points[1] || points[1] == points[2] || points[2] == points[0];
        if (is_whole && !is_flat) out.triangles.push_back(points);
    }
    return out;
}

}  // namespace

LoadResult vertices_as_points(const TexturedMesh& model, const std::string& kind,
                              const std::filesystem::path& path, const Context& context) {
    PointRows vertices;
    vertices.cloud.positions = model.mesh.positions;
    vertices.cloud.colors = model.mesh.colors;
    FinishedCloud finished =
        finish_cloud(std::move(vertices), kind + " mesh", path.string(), context);
    LoadResult& result = finished.result;
    result.mesh = over_points(model.mesh, result.cloud, finished.point_of_row);
    result.report.num_bad_faces = model.mesh.triangles.size() - result.mesh->triangles.size();
    result.report.notes.emplace_back("the vertices of the mesh are the points");
    if (!model.images.empty())
        result.report.notes.emplace_back(
            "its textures are not read: make points of them with pointbake sample");
    return std::move(result);
}

TexturedMesh faces_as_mesh(LoadResult loaded, const std::filesystem::path& path) {
    if (!loaded.mesh)
        fail(ErrorCode::kInvalidInput, "{}: the file holds no faces; a mesh is wanted",
             path.string());
    TexturedMesh mesh;
    mesh.mesh = std::move(*loaded.mesh);
    return finish_mesh(std::move(mesh), path.string());
}

}  // namespace pointbake
