// Based on the Khronos glTF 2.0 specification [glTF2], 3.5 (scenes), 3.7 (meshes), 3.9 (materials).
#include "io/read_gltf.h"

#include <algorithm>
#include <array>
#include <map>

#include "core/color.h"
#include "core/message.h"
#include "core/parallel.h"
#include "io/gltf_file.h"
#include "io/mesh_builder.h"

namespace pointbake {
namespace {

using Json = GltfFile::Json;

/// x -> columns * x + translation
struct Affine {
    std::array<Vec3d, 3> columns{Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}};
    Vec3d translation;

    Vec3d linear(Vec3d v) const { return columns[0] * v.x + columns[1] * v.y + columns[2] * v.z; }
    Vec3d operator()(Vec3d p) const { return linear(p) + translation; }
    Affine operator*(const Affine& inner) const {
        return {{linear(inner.columns[0]), linear(inner.columns[1]), linear(inner.columns[2])},
                (*this)(inner.translation)};
    }
    bool mirrors() const { return dot(cross(columns[0], columns[1]), columns[2]) < 0.0; }
};

Affine transform_of(const GltfFile& file, const Json& node) {
    if (const auto m = file.numbers(node, "matrix", 16); !m.empty())
        return {{Vec3d{m[0], m[1], m[2]}, Vec3d{m[4], m[5], m[6]}, Vec3d{m[8], m[9], m[10]}},
                {m[12], m[13], m[14]}};
    Affine out;
    if (const auto t = file.numbers(node, "translation", 3); !t.empty())
        out.translation = {t[0], t[1], t[2]};
    if (const auto q = file.numbers(node, "rotation", 4); !q.empty()) {
        const double x = q[0], y = q[1], z = q[2], w = q[3];
        out.columns = {Vec3d{1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)},
                       Vec3d{2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)},
                       Vec3d{2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)}};
    }
    if (const auto s = file.numbers(node, "scale", 3); !s.empty())
        for (std::size_t k = 0; k < 3; ++k) out.columns[k] = out.columns[k] * s[k];
    return out;
}

const Json* member(const Json& object, const char* key) {
    const auto found = object.find(key);
    return found == object.end() || !found->is_object() ? nullptr : &*found;
}

/// How a material's texture coordinates are found.
struct UvSource {
    std::size_t set = 0;
    Vec2f scale{1.0F, 1.0F}, offset;
};

struct ReadMaterial {
    Index index = 0;  ///< in the mesh
    UvSource uv;
};

class GltfReader {
 public:
    GltfReader(const GltfFile& file, const Context& context) : file_(file), context_(context) {}

    TexturedMesh read() {
        check_extensions();
        walk_scene();
        if (!has_uvs_) mesh_.mesh.uvs.clear();
        if (!has_colors_) mesh_.mesh.colors.clear();
        return finish_mesh(std::move(mesh_), file_.name());
    }

 private:
    [[noreturn]] void fail_here(std::string_view problem) const {
        fail(ErrorCode::kInvalidInput, "{}: {}", file_.name(), problem);
    }

    void check_extensions() const {
        constexpr std::array<std::string_view, 3> kKnown{
            "KHR_mesh_quantization", "KHR_texture_transform", "EXT_texture_webp"};
        const auto required = file_.json().find("extensionsRequired");
        if (required == file_.json().end() || !required->is_array()) return;
        for (const Json& entry : *required) {
            const std::string name = entry.is_string() ? entry.get<std::string>() : "?";
            if (!name.starts_with("KHR_materials_") &&
                std::find(kKnown.begin(), kKnown.end(), name) == kKnown.end())
                fail(ErrorCode::kUnsupported,
                     "{}: needs the extension {}, which is not read; export without it",
                     file_.name(), name);
        }
    }

    /// Pushes the nodes of an array in reverse, so that the first is taken first.
    struct Visit {
        std::size_t node;
        Affine parent;
    };
    void push_nodes(const Json& owner, const char* key, const Affine& parent,
                    std::vector<Visit>& stack) const {
        const auto array = owner.find(key);
        if (array == owner.end() || !array->is_array()) return;
        for (auto entry = array->rbegin(); entry != array->rend(); ++entry) {
            if (!entry->is_number_unsigned()) fail_here("a node's number is no integer");
            stack.push_back({entry->get<std::size_t>(), parent});
        }
    }

    void walk_scene() {
        std::vector<Visit> stack;
        const std::size_t num_nodes =
            file_.json().contains("nodes") ? file_.json()["nodes"].size() : 0;
        if (file_.json().contains("scenes")) {
            const std::size_t scene = file_.index(file_.json(), "scene").value_or(0);
            push_nodes(file_.entry("scenes", scene), "nodes", {}, stack);
        } else {
            push_roots(num_nodes, stack);
        }
        std::vector<bool> visited(num_nodes);
        while (!stack.empty()) {
            const Visit visit = stack.back();
            stack.pop_back();
            const Json& node = file_.entry("nodes", visit.node);
            if (visited[visit.node]) fail_here("a node has two parents");
            visited[visit.node] = true;
            const Affine world = visit.parent * transform_of(file_, node);
            if (const auto mesh = file_.index(node, "mesh")) read_mesh(*mesh, world);
            push_nodes(node, "children", world, stack);
        }
    }

    void push_roots(std::size_t num_nodes, std::vector<Visit>& stack) const {
        std::vector<Visit> children;
        for (std::size_t i = 0; i < num_nodes; ++i)
            push_nodes(file_.entry("nodes", i), "children", {}, children);
        std::vector<bool> is_child(num_nodes);
        for (const Visit& c : children)
            if (c.node < num_nodes) is_child[c.node] = true;
        for (std::size_t i = num_nodes; i-- > 0;)
            if (!is_child[i]) stack.push_back({i, {}});
    }

    void read_mesh(std::size_t index, const Affine& world) {
        const Json& mesh = file_.entry("meshes", index);
        const auto primitives = mesh.find("primitives");
        if (primitives == mesh.end() || !primitives->is_array())
            fail_here("a mesh without primitives");
        for (const Json& primitive : *primitives) {
            check_cancelled(context_);
            if (!primitive.is_object() || member(primitive, "attributes") == nullptr)
                fail_here("a primitive without attributes");
            read_primitive(primitive, world);
        }
    }

    void read_primitive(const Json& primitive, const Affine& world) {
        const std::size_t mode = file_.index(primitive, "mode").value_or(4);
        const Json& attributes = primitive["attributes"];
        const auto position = file_.index(attributes, "POSITION");
        if (mode < 4 || mode > 6 || !position) return;  // points and lines
        const GltfValues points = file_.accessor(*position);
        if (points.width != 3) fail_here("POSITION is no VEC3");
        Mesh& mesh = mesh_.mesh;
        const std::size_t base = mesh.positions.size();
        if (points.count > kInvalidIndex - 1 - base)
            fail(ErrorCode::kLimit, "{}: more than 2^32 - 2 vertices", file_.name());
        for (std::size_t i = 0; i < points.count; ++i)
            mesh.positions.push_back(world({points.at(i, 0), points.at(i, 1), points.at(i, 2)}));
        read_colors(attributes, points.count);

        const ReadMaterial material = material_of(primitive);
        const std::vector<Vec2f> uvs = read_uvs(attributes, material.uv, points.count);
        const auto add = [&](Index a, Index b, Index c) {
            if (world.mirrors()) std::swap(b, c);
            const auto at = [&](Index i) { return static_cast<Index>(base + i); };
            mesh.triangles.push_back({at(a), at(b), at(c)});
            mesh.uvs.push_back(uvs.empty() ? std::array<Vec2f, 3>{}
                                           : std::array<Vec2f, 3>{uvs[a], uvs[b], uvs[c]});
            mesh_.triangle_materials.push_back(material.index);
        };
        const std::vector<Index> corners = read_corners(primitive, points.count);
        if (mode == 4)
            for (std::size_t i = 0; i + 2 < corners.size(); i += 3)
                add(corners[i], corners[i + 1], corners[i + 2]);
        else
            for (std::size_t i = 0; i + 2 < corners.size(); ++i)
                if (mode == 6)
                    add(corners[0], corners[i + 1], corners[i + 2]);
                else
                    add(corners[i], corners[i + 1 + i % 2], corners[i + 2 - i % 2]);
    }

    std::vector<Index> read_corners(const Json& primitive, std::size_t num_points) const {
        std::vector<Index> corners;
        if (const auto index = file_.index(primitive, "indices")) {
            const GltfValues values = file_.accessor(*index);
            corners.reserve(values.values.size());
            for (double value : values.values) {
                if (!(value >= 0.0 && value < static_cast<double>(num_points)))
                    fail_here("an index names no vertex");
                corners.push_back(static_cast<Index>(value));
            }
        } else {
            for (std::size_t i = 0; i < num_points; ++i) corners.push_back(static_cast<Index>(i));
        }
        return corners;
    }

    /// COLOR_0 is linear; white where a primitive has none.
    void read_colors(const Json& attributes, std::size_t count) {
        std::vector<Rgb16>& colors = mesh_.mesh.colors;
        const auto index = file_.index(attributes, "COLOR_0");
        if (!index) {
            colors.resize(colors.size() + count, Rgb16{65535, 65535, 65535});
            return;
        }
        const GltfValues values = file_.accessor(*index);
        if (values.width < 3 || values.count != count) fail_here("COLOR_0 does not fit POSITION");
        has_colors_ = true;
        const auto code = [](double linear) {
            return static_cast<std::uint16_t>(linear_to_srgb_exact(linear) * 65535.0 + 0.5);
        };
        for (std::size_t i = 0; i < count; ++i)
            colors.push_back({code(values.at(i, 0)), code(values.at(i, 1)), code(values.at(i, 2))});
    }

    std::vector<Vec2f> read_uvs(const Json& attributes, const UvSource& source, std::size_t count) {
        std::vector<Vec2f> uvs;
        const auto index = file_.index(attributes, fmt::format("TEXCOORD_{}", source.set).c_str());
        if (!index) return uvs;
        const GltfValues values = file_.accessor(*index);
        if (values.width != 2 || values.count != count) fail_here("TEXCOORD does not fit POSITION");
        has_uvs_ = true;
        for (std::size_t i = 0; i < count; ++i)
            uvs.push_back({static_cast<float>(values.at(i, 0)) * source.scale.x + source.offset.x,
                           static_cast<float>(values.at(i, 1)) * source.scale.y + source.offset.y});
        return uvs;
    }

    /// Materials are read when the first primitive uses them; ~0 stands for the default one.
    ReadMaterial material_of(const Json& primitive) {
        const std::size_t number = file_.index(primitive, "material").value_or(~std::size_t{0});
        if (const auto known = materials_.find(number); known != materials_.end())
            return known->second;
        ReadMaterial out;
        out.index = static_cast<Index>(mesh_.materials.size());
        Material material;
        if (number != ~std::size_t{0}) {
            const Json& json = file_.entry("materials", number);
            if (const auto name = json.find("name"); name != json.end() && name->is_string())
                material.name = name->get<std::string>();
            if (const Json* pbr = member(json, "pbrMetallicRoughness"))
                out.uv = read_pbr(*pbr, material);
        }
        mesh_.materials.push_back(std::move(material));
        materials_.emplace(number, out);
        return out;
    }

    UvSource read_pbr(const Json& pbr, Material& material) {
        UvSource uv;
        if (const auto factor = file_.numbers(pbr, "baseColorFactor", 4); !factor.empty())
            material.base_color = {factor[0], factor[1], factor[2]};
        const Json* reference = member(pbr, "baseColorTexture");
        if (reference == nullptr) return uv;
        uv.set = file_.index(*reference, "texCoord").value_or(0);
        const Json* extensions = member(*reference, "extensions");
        const Json* transform =
            extensions == nullptr ? nullptr : member(*extensions, "KHR_texture_transform");
        if (transform != nullptr) read_transform(*transform, uv);
        const Json& texture = file_.entry("textures", file_.index_or_fail(*reference, "index"));
        if (const auto source = image_source(texture))
            material.color_image = image_of(*source);
        else
            log(context_, LogLevel::kWarning,
                "{}: a texture that is neither PNG nor JPEG nor WebP: its material stays plain",
                file_.name());
        return uv;
    }

    /// The number of a texture's image, WebP first.
    std::optional<std::size_t> image_source(const Json& texture) const {
        const Json* extensions = member(texture, "extensions");
        const Json* webp =
            extensions == nullptr ? nullptr : member(*extensions, "EXT_texture_webp");
        const auto source = webp == nullptr ? std::nullopt : file_.index(*webp, "source");
        return source ? source : file_.index(texture, "source");
    }

    void read_transform(const Json& transform, UvSource& uv) const {
        const auto rotation = transform.find("rotation");
        if (rotation != transform.end() && *rotation != 0.0)
            fail(ErrorCode::kUnsupported, "{}: rotated texture coordinates are not read",
                 file_.name());
        if (const auto set = file_.index(transform, "texCoord")) uv.set = *set;
        if (const auto s = file_.numbers(transform, "scale", 2); !s.empty())
            uv.scale = {static_cast<float>(s[0]), static_cast<float>(s[1])};
        if (const auto o = file_.numbers(transform, "offset", 2); !o.empty())
            uv.offset = {static_cast<float>(o[0]), static_cast<float>(o[1])};
    }

    int image_of(std::size_t source) {
        const auto [entry, is_new] =
            images_.try_emplace(source, static_cast<int>(mesh_.images.size()));
        if (is_new) mesh_.images.push_back(file_.image(source));
        return entry->second;
    }

    const GltfFile& file_;
    const Context& context_;
    TexturedMesh mesh_;
    std::map<std::size_t, ReadMaterial> materials_;
    std::map<std::size_t, int> images_;
    bool has_uvs_ = false;
    bool has_colors_ = false;
};

}  // namespace

TexturedMesh read_gltf(std::span<const std::byte> bytes, const std::filesystem::path& path,
                       const Context& context) {
    const GltfFile file(bytes, path);
    return GltfReader(file, context).read();
}

}  // namespace pointbake
