#include "io/mesh_builder.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "core/color.h"
#include "core/message.h"
#include "io/image_io.h"

namespace pointbake {
namespace {

std::uint16_t coded(double linear) {
    return static_cast<std::uint16_t>(linear_to_srgb_exact(linear) * 65535.0 + 0.5);
}

/// The lowest vertex of equal position, for every vertex.
std::vector<Index> lowest_equal(const std::vector<Vec3d>& positions) {
    std::vector<Index> order(positions.size());
    std::iota(order.begin(), order.end(), Index{0});
    std::sort(order.begin(), order.end(), [&](Index a, Index b) {
        const Vec3d& p = positions[a];
        const Vec3d& q = positions[b];
        return std::tie(p.x, p.y, p.z, a) < std::tie(q.x, q.y, q.z, b);
    });
    std::vector<Index> lowest(positions.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
        const bool is_same = i > 0 && positions[order[i]] == positions[order[i - 1]];
        lowest[order[i]] = is_same ? lowest[order[i - 1]] : order[i];
    }
    return lowest;
}

void merge_colors(std::vector<Rgb16>& colors, const std::vector<Index>& lowest) {
    struct Sum {
        Vec3d linear;
        double count = 0.0;
    };
    std::vector<Sum> sums(colors.size());
    std::vector<bool> differ(colors.size());
    for (std::size_t v = 0; v < colors.size(); ++v) {
        Sum& sum = sums[lowest[v]];
        sum.linear += vec_cast<double>(to_linear(colors[v]));
        sum.count += 1.0;
        if (!(colors[v] == colors[lowest[v]])) differ[lowest[v]] = true;
    }
    for (std::size_t v = 0; v < colors.size(); ++v) {
        if (!differ[v]) continue;
        const Vec3d mean = sums[v].linear / sums[v].count;
        colors[v] = {coded(mean.x), coded(mean.y), coded(mean.z)};
    }
}

/// Keeps the entries of per-triangle data that `keep` marks.
template <class T>
void keep_marked(std::vector<T>& values, const std::vector<bool>& keep) {
    if (values.empty()) return;
    std::size_t n = 0;
    for (std::size_t i = 0; i < keep.size(); ++i)
        if (keep[i]) values[n++] = values[i];
    values.resize(n);
}

void drop_degenerate(TexturedMesh& mesh) {
    std::vector<bool> keep(mesh.mesh.triangles.size());
    for (std::size_t t = 0; t < keep.size(); ++t) {
        const Triangle& c = mesh.mesh.triangles[t];
        keep[t] = c[0] != c[1] && c[1] != c[2] && c[2] != c[0];
    }
    keep_marked(mesh.mesh.triangles, keep);
    keep_marked(mesh.mesh.uvs, keep);
    keep_marked(mesh.triangle_materials, keep);
}

void drop_unused_vertices(Mesh& mesh) {
    std::vector<bool> used(mesh.positions.size());
    for (const Triangle& t : mesh.triangles)
        for (Index v : t) used[v] = true;
    std::vector<Index> new_index(used.size(), kInvalidIndex);
    Index n = 0;
    for (std::size_t v = 0; v < used.size(); ++v)
        if (used[v]) new_index[v] = n++;
    keep_marked(mesh.positions, used);
    keep_marked(mesh.colors, used);
    for (Triangle& t : mesh.triangles)
        for (Index& v : t) v = new_index[v];
}

}  // namespace

void weld_in_place(TexturedMesh& mesh, const std::string& name) {
    for (std::size_t v = 0; v < mesh.mesh.positions.size(); ++v) {
        mesh.mesh.positions[v] += Vec3d{};  // -0 becomes 0
        if (!is_finite(mesh.mesh.positions[v]))
            fail(ErrorCode::kInvalidInput, "{}: the coordinates of vertex {} are not finite", name,
                 v);
    }
    const std::vector<Index> lowest = lowest_equal(mesh.mesh.positions);
    if (!mesh.mesh.colors.empty()) merge_colors(mesh.mesh.colors, lowest);
    for (Triangle& t : mesh.mesh.triangles)
        for (Index& v : t) v = lowest[v];
    drop_degenerate(mesh);
    drop_unused_vertices(mesh.mesh);
}

TexturedMesh finish_mesh(TexturedMesh mesh, const std::string& name) {
    weld_in_place(mesh, name);
    if (mesh.mesh.triangles.empty())
        fail(ErrorCode::kEmpty, "{}: the file holds no triangles; a mesh is wanted", name);
    if (mesh.materials.empty()) mesh.materials.emplace_back();
    if (mesh.materials.size() == 1) mesh.triangle_materials.clear();
    for (std::array<Vec2f, 3>& corners : mesh.mesh.uvs)
        for (Vec2f& uv : corners)
            if (!std::isfinite(uv.x) || !std::isfinite(uv.y)) uv = {};
    return mesh;
}

int TextureFiles::load(std::string name, TexturedMesh& mesh) {
    std::replace(name.begin(), name.end(), '\\', '/');
    const auto [entry, is_new] = images_.try_emplace(name, -1);
    if (!is_new) return entry->second;
    const std::filesystem::path path = folder_ / name;
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error)) {
        log(context_, LogLevel::kWarning, "{}: texture not found: its material stays plain",
            path.string());
        return -1;
    }
    mesh.images.push_back(read_image(path));
    entry->second = static_cast<int>(mesh.images.size()) - 1;
    return entry->second;
}

}  // namespace pointbake
