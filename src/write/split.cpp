#include "write/split.h"

#include <algorithm>
#include <bit>
#include <numeric>

#include "core/hash.h"
#include "core/message.h"
#include "core/parallel.h"

namespace pointbake {
namespace {

constexpr std::size_t kTrianglesPerPoll = std::size_t{1} << 16;  // about a millisecond of work

void check_size(std::string_view what, std::size_t size, std::size_t expected) {
    if (size != 0 && size != expected)
        fail(ErrorCode::kInvalidInput, "the mesh has {} {} instead of {} or none", size, what,
             expected);
}

bool is_finite(Vec2f a) { return std::isfinite(a.x) && std::isfinite(a.y); }

void check_images(const TexturedMesh& model) {
    const auto num_images = static_cast<int>(model.images.size());
    for (const Material& m : model.materials)
        if (m.color_image >= num_images || m.normal_image >= num_images)
            fail(ErrorCode::kInvalidInput, "material '{}' uses image {} of {}", m.name,
                 std::max(m.color_image, m.normal_image), num_images);
}

/// A set of a part's vertices, by what makes them differ. Open addressing; only the order of
/// insertion is ever seen.
class VertexSet {
 public:
    VertexSet(const TexturedMesh& model, std::span<const Triangle> triangles, SplitOptions options,
              std::size_t num_corners)
        : model_(model),
          triangles_(triangles),
          options_(options),
          slots_(std::bit_ceil(2 * num_corners + 1), kInvalidIndex),
          mask_(slots_.size() - 1) {}

    /// The vertex of a corner; new ones are appended to `corners`.
    Index find_or_add(Index corner, std::vector<Index>& corners) {
        for (std::size_t slot = hash(corner) & mask_;; slot = (slot + 1) & mask_) {
            if (slots_[slot] == kInvalidIndex) {
                slots_[slot] = static_cast<Index>(corners.size());
                corners.push_back(corner);
                return slots_[slot];
            }
            if (are_equal(corners[slots_[slot]], corner)) return slots_[slot];
        }
    }

 private:
    Index vertex(Index corner) const { return triangles_[corner / 3][corner % 3]; }
    Vec2f uv(Index corner) const { return model_.mesh.uvs[corner / 3][corner % 3]; }

    std::uint64_t hash(Index corner) const {
        std::uint64_t h = hash64(vertex(corner));
        if (options_.by_uv) {
            const Vec2f t = uv(corner) + Vec2f{0.0F, 0.0F};  // -0 becomes 0
            h = hash64(h, std::uint64_t{std::bit_cast<std::uint32_t>(t.x)} << 32 |
                              std::bit_cast<std::uint32_t>(t.y));
        }
        return h;
    }

    bool are_equal(Index a, Index b) const {
        if (vertex(a) != vertex(b)) return false;
        if (options_.by_uv && !(uv(a) == uv(b))) return false;
        if (options_.tangents == nullptr || a / 3 == b / 3) return true;
        const Tangents& tangents = *options_.tangents;
        return tangents.directions[a / 3] == tangents.directions[b / 3] &&
               tangents.signs[a / 3] == tangents.signs[b / 3];
    }

    const TexturedMesh& model_;
    std::span<const Triangle> triangles_;
    SplitOptions options_;
    std::vector<Index> slots_;
    std::size_t mask_;
};

bool is_collapsed(const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

/// Root of v's group, with path halving; a root is the least vertex of its group.
Index find_root(std::vector<Index>& parents, Index v) {
    while (parents[v] != v) v = parents[v] = parents[parents[v]];
    return v;
}

}  // namespace

void check_model(const TexturedMesh& model) {
    const Mesh& mesh = model.mesh;
    const std::size_t num_vertices = mesh.positions.size(), num_triangles = mesh.triangles.size();
    if (num_triangles > kInvalidIndex / 3)
        fail(ErrorCode::kLimit, "the mesh has {} triangles; at most {} can be written",
             num_triangles, kInvalidIndex / 3);
    check_size("normals", mesh.normals.size(), num_vertices);
    check_size("colours", mesh.colors.size(), num_vertices);
    check_size("triangles with texture coordinates", mesh.uvs.size(), num_triangles);
    check_size("tangents", model.corner_tangents.size(), num_triangles);
    check_size("tangent signs", model.tangent_signs.size(), model.corner_tangents.size());
    check_size("triangle materials", model.triangle_materials.size(), num_triangles);
    check_images(model);
    const std::size_t num_materials = std::max<std::size_t>(1, model.materials.size());
    for (std::size_t t = 0; t < num_triangles; ++t) {
        for (const Index v : mesh.triangles[t]) {
            if (v >= num_vertices)
                fail(ErrorCode::kInvalidInput, "triangle {} uses vertex {} of {}", t, v,
                     num_vertices);
            if (!is_finite(mesh.positions[v]))
                fail(ErrorCode::kInvalidInput, "vertex {} is not finite", v);
        }
        if (material_of(model, t) >= num_materials)
            fail(ErrorCode::kInvalidInput, "triangle {} uses material {} of {}", t,
                 material_of(model, t), num_materials);
        if (mesh.uvs.empty()) continue;
        for (const Vec2f uv : mesh.uvs[t])
            if (!is_finite(uv))
                fail(ErrorCode::kInvalidInput,
                     "triangle {} has a texture coordinate that is not finite", t);
    }
}

std::vector<MeshPart> split_by_material(const TexturedMesh& model,
                                        std::span<const Triangle> triangles,
                                        std::span<const SplitOptions> options,
                                        const Context& context) {
    std::vector<std::vector<Index>> by_material(options.size());
    for (std::size_t t = 0; t < triangles.size(); ++t)
        if (!is_collapsed(triangles[t]))
            by_material[material_of(model, t)].push_back(static_cast<Index>(t));

    std::vector<MeshPart> parts;
    for (std::size_t m = 0; m < options.size(); ++m) {
        if (by_material[m].empty()) continue;
        MeshPart part{.material = static_cast<Index>(m), .corners = {}, .indices = {}};
        part.indices.reserve(3 * by_material[m].size());
        VertexSet vertices(model, triangles, options[m], 3 * by_material[m].size());
        for (const Index t : by_material[m]) {
            if (part.indices.size() % (3 * kTrianglesPerPoll) == 0) check_cancelled(context);
            for (Index k = 0; k < 3; ++k)
                part.indices.push_back(vertices.find_or_add(3 * t + k, part.corners));
        }
        parts.push_back(std::move(part));
    }
    return parts;
}

std::vector<Triangle> contract_equal(std::span<const Triangle> triangles,
                                     std::span<const Vec3f> positions) {
    std::vector<Triangle> out(triangles.begin(), triangles.end());
    std::vector<Index> parents;
    for (const Triangle& t : triangles) {
        for (std::size_t k = 0; k < 3; ++k) {
            const Index a = t[k], b = t[(k + 1) % 3];
            if (a == b || !(positions[a] == positions[b])) continue;
            if (parents.empty()) {
                parents.resize(positions.size());
                std::iota(parents.begin(), parents.end(), Index{0});
            }
            const Index x = find_root(parents, a), y = find_root(parents, b);
            parents[std::max(x, y)] = std::min(x, y);
        }
    }
    if (!parents.empty())
        for (Triangle& t : out)
            for (Index& v : t) v = find_root(parents, v);
    return out;
}

}  // namespace pointbake
