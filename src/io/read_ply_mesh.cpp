// Texture coordinates come per face (MeshLab: texcoord, texnumber) or per vertex (Blender: s, t;
// MeshLab: texture_u, texture_v); their origin is the lower left corner of the image.
#include <algorithm>
#include <array>
#include <numeric>

#include "core/message.h"
#include "core/parallel.h"
#include "io/mesh_builder.h"
#include "io/ply_faces.h"
#include "io/ply_points.h"
#include "io/read_ply.h"

namespace pointbake {
namespace {

/// Texture files that comments name; "<this>" stands for the PLY file's own name.
std::vector<std::string> texture_files(const PlyHeader& header, const std::filesystem::path& path) {
    constexpr std::string_view kKey = "TextureFile";
    constexpr std::string_view kThis = "<this>";
    std::vector<std::string> files;
    for (const std::string& comment : header.comments) {
        if (!comment.starts_with(kKey)) continue;
        const std::size_t begin = comment.find_first_not_of(" \t", kKey.size());
        if (begin == std::string::npos) continue;
        std::string name = comment.substr(begin);
        if (const std::size_t at = name.find(kThis); at != std::string::npos)
            name.replace(at, kThis.size(), path.stem().string());
        files.push_back(std::move(name));
    }
    return files;
}

/// Takes texture coordinates out of the vertices' channels.
std::vector<Vec2f> vertex_uvs(const std::vector<Channel>& channels) {
    using Names = std::array<std::string_view, 2>;
    for (const Names& names : {Names{"s", "t"}, Names{"u", "v"}, Names{"texture_u", "texture_v"}}) {
        const auto find = [&](std::string_view name) {
            return std::find_if(channels.begin(), channels.end(),
                                [&](const Channel& c) { return c.name == name; });
        };
        const auto u = find(names[0]), v = find(names[1]);
        if (u == channels.end() || v == channels.end()) continue;
        std::vector<Vec2f> uvs(u->data.size());
        for (std::size_t i = 0; i < uvs.size(); ++i) uvs[i] = {u->data[i], v->data[i]};
        return uvs;
    }
    return {};
}

void add_uvs(PlyFaces& faces, const std::vector<Channel>& channels, TexturedMesh& mesh) {
    std::vector<std::array<Vec2f, 3>>& uvs = mesh.mesh.uvs = std::move(faces.uvs);
    if (uvs.empty()) {
        const std::vector<Vec2f> per_vertex = vertex_uvs(channels);
        if (per_vertex.empty()) return;
        uvs.reserve(mesh.mesh.triangles.size());
        for (const Triangle& t : mesh.mesh.triangles)
            uvs.push_back({per_vertex[t[0]], per_vertex[t[1]], per_vertex[t[2]]});
    }
    for (std::array<Vec2f, 3>& corners : uvs)
        for (Vec2f& uv : corners) uv.y = 1.0F - uv.y;
}

/// One material per texture file; texture numbers beyond them take the first.
void add_materials(const std::vector<std::string>& files, const PlyFaces& faces,
                   TextureFiles& textures, TexturedMesh& mesh) {
    for (const std::string& file : files) {
        Material material;
        material.name = file;
        material.color_image = textures.load(file, mesh);
        mesh.materials.push_back(std::move(material));
    }
    if (files.size() < 2 || faces.textures.empty()) {
        if (files.size() > 1) mesh.triangle_materials.assign(mesh.mesh.triangles.size(), 0);
        return;
    }
    mesh.triangle_materials = faces.textures;
    for (Index& m : mesh.triangle_materials)
        if (m >= files.size()) m = 0;
}

}  // namespace

TexturedMesh read_ply_mesh(std::span<const std::byte> bytes, const std::filesystem::path& path,
                           const Context& context) {
    const std::string name = path.string();
    const PlyHeader header = read_ply_header(bytes, name);
    const auto points = header.find("vertex");
    const auto face_element = find_faces(header);
    if (!points || !face_element)
        fail(ErrorCode::kInvalidInput,
             "{}: the file holds no faces (elements 'vertex' and 'face'); a mesh is wanted", name);
    const PlyBody body(bytes, header, std::max(*points, *face_element) + 1, name, context);
    PointRows read = read_ply_points(body, header, *points, name, context);
    std::vector<Index> same_index(read.cloud.size());
    std::iota(same_index.begin(), same_index.end(), Index{0});
    PlyFaces faces = read_ply_faces(body, header, *face_element, same_index, true, context);
    if (faces.num_bad > 0)
        log(context, LogLevel::kWarning, "{}: {} faces dropped: bad or repeated corners", name,
            faces.num_bad);

    TexturedMesh mesh;
    mesh.mesh.positions = std::move(read.cloud.positions);
    mesh.mesh.colors = std::move(read.cloud.colors);
    mesh.mesh.triangles = std::move(faces.triangles);
    add_uvs(faces, read.cloud.channels, mesh);
    TextureFiles textures(path.parent_path(), context);
    add_materials(texture_files(header, path), faces, textures, mesh);
    return finish_mesh(std::move(mesh), name);
}

}  // namespace pointbake
