// Based on [glTF20] and KHR_materials_unlit. Vertices are never laid out in
// memory: they are looked up in the model while they are written.
#include "write/write_gltf.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/color.h"
#include "core/message.h"
#include "write/file_set.h"
#include "write/frame.h"
#include "write/gltf_buffer.h"
#include "write/placement.h"
#include "write/png.h"
#include "write/split.h"
#include "write/tangents.h"

namespace pointbake {
namespace {

constexpr int kArrayBuffer = 34962, kElementArrayBuffer = 34963;
constexpr int kUnsignedShort = 5123, kUnsignedInt = 5125, kFloat = 5126;
constexpr int kLinear = 9729, kLinearMipmapLinear = 9987, kClampToEdge = 33071, kRepeat = 10497;
constexpr std::size_t kMaxShortIndex = 65534;  // 65535 restarts primitives
constexpr std::uint64_t kMaxGlbBytes = ~std::uint32_t{0};
constexpr std::uint64_t kGlbHeaderBytes = 12, kChunkHeaderBytes = 8;

/// How a material is drawn, and so what its vertices need.
struct Look {
    bool is_lit = false;
    bool has_color_image = false;
    bool has_normal_image = false;
    bool has_vertex_colors = false;
    bool has_uvs() const { return has_color_image || has_normal_image; }
};

Look look_of(const Mesh& mesh, const Material& material, Shading shading) {
    Look look;
    look.has_color_image = !mesh.uvs.empty() && material.color_image >= 0;
    look.has_normal_image = !mesh.uvs.empty() && material.normal_image >= 0;
    // A viewer would multiply a texture by vertex colours.
    look.has_vertex_colors = !look.has_color_image && !mesh.colors.empty();
    const bool has_color = look.has_color_image || look.has_vertex_colors ||
                           material.base_color != std::array<double, 3>{1.0, 1.0, 1.0};
    // Unlit, a normal map would be ignored and a surface without colour be a white outline.
    look.is_lit = shading == Shading::kLit || look.has_normal_image || !has_color;
    return look;
}

/// The turn that makes an axis of the input point along +y. Never mirrored.
Json rotation_to_y(UpAxis up) {
    const double half = std::sqrt(0.5);
    if (up == UpAxis::kX) return {0.0, 0.0, half, half};
    if (up == UpAxis::kZ) return {-half, 0.0, 0.0, half};
    if (up == UpAxis::kMinusY) return {1.0, 0.0, 0.0, 0.0};
    return {};
}

/// Bytes of a URI that need no escape (RFC 3986, unreserved).
std::string uri_of(const std::filesystem::path& path) {
    std::string uri;
    for (const char c : path.filename().string()) {
        const bool is_plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                              (c >= '0' && c <= '9') ||
                              std::string_view("-._~").find(c) != std::string_view::npos;
        if (is_plain)
            uri += c;
        else
            uri += fmt::format("%{:02X}", static_cast<unsigned char>(c));
    }
    return uri;
}

/// Compact JSON; bytes that are no UTF-8 (of a material's name) are replaced.
std::string to_text(const Json& json) {
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

class GltfWriter {
 public:
    GltfWriter(const TexturedMesh& model, const std::filesystem::path& path,
               const WriteOptions& options, const Context& context);

    WriteReport run();

 private:
    using Color4 = std::array<std::uint16_t, 4>;
    using Tangent4 = std::array<float, 4>;

    Json nodes() const;
    Json extras() const;
    Json material(Index index) const;
    Json texture_info(int image) const;
    Json sampler_of(std::size_t texture) const;
    Json samplers(std::vector<std::size_t>& of_texture) const;
    Json primitive(const MeshPart& part, std::size_t material_index);
    Json position_accessor(const MeshPart& part) const;
    std::size_t add_indices(const MeshPart& part);
    void use_image(int image);
    Json document(const std::vector<Json>& images, std::string_view buffer_uri);

    void write_glb(AtomicFile& file);
    void write_separate(FileSet& files, AtomicFile& main);
    void report_image(std::size_t num_done) const;

    Index vertex(Index corner) const { return triangles_[corner / 3][corner % 3]; }

    const TexturedMesh& model_;
    const std::filesystem::path& path_;
    Frame frame_;
    const Context& context_;
    bool is_glb_;

    std::vector<Material> materials_;
    std::vector<Look> looks_;  // one per material
    Placement32 placement_;
    std::vector<Triangle> triangles_;
    std::vector<Vec3f> normals_;  // empty if nothing is lit
    Tangents tangents_;           // empty if there is no normal map
    std::vector<MeshPart> parts_;
    std::vector<int> used_images_;              // the image of each texture
    std::vector<std::vector<std::byte>> pngs_;  // of a GLB
    GltfBuffer buffer_;
    Json primitives_ = Json::array();
};

GltfWriter::GltfWriter(const TexturedMesh& model, const std::filesystem::path& path,
                       const WriteOptions& options, const Context& context)
    : model_(model),
      path_(path),
      frame_(settled_frame(model.frame, options)),
      context_(context),
      is_glb_(path.extension().string().size() == 4),  // else .gltf
      materials_(model.materials),
      buffer_(context) {
    if (materials_.empty()) materials_.emplace_back();
    const Mesh& mesh = model.mesh;
    placement_ = place_as_floats(mesh.positions, mesh.triangles);
    triangles_ = contract_equal(mesh.triangles, placement_.positions);

    std::vector<SplitOptions> splits;
    for (const Material& m : materials_) {
        looks_.push_back(look_of(mesh, m, options.shading));
        splits.push_back({.by_uv = looks_.back().has_uvs(),
                          .tangents = looks_.back().has_normal_image ? &tangents_ : nullptr});
    }
    const auto any = [&](bool Look::* what) {
        return std::any_of(looks_.begin(), looks_.end(), [&](const Look& l) { return l.*what; });
    };
    if (any(&Look::is_lit)) normals_ = unit_normals(mesh);
    if (any(&Look::has_normal_image)) tangents_ = triangle_tangents(model);
    parts_ = split_by_material(model, triangles_, splits, context);
    if (parts_.empty())
        fail(ErrorCode::kEmpty, "cannot write '{}': the mesh has no triangles", path.string());
    for (const MeshPart& part : parts_) {
        const Look& look = looks_[part.material];
        if (look.has_color_image) use_image(materials_[part.material].color_image);
        if (look.has_normal_image) use_image(materials_[part.material].normal_image);
    }
}

void GltfWriter::use_image(int image) {
    if (std::find(used_images_.begin(), used_images_.end(), image) == used_images_.end())
        used_images_.push_back(image);
}

/// What leads back to the input's coordinates: global_shift + POSITION.
Json GltfWriter::extras() const {
    Json extras = Json::object();
    if (placement_.has_translation()) {
        const Vec3d t = placement_.translation;
        extras["global_shift"] = {t.x, t.y, t.z};
    }
    if (frame_.up != UpAxis::kAuto) extras["up"] = to_word(frame_.up);
    if (frame_.metres_per_unit != 0.0) extras["metres_per_unit"] = frame_.metres_per_unit;
    const Crs& crs = frame_.crs;
    if (crs.name.empty()) return extras;
    extras["crs"] = {{"name", crs.name}};
    if (crs.epsg != 0) extras["crs"]["epsg"] = crs.epsg;
    if (!crs.vertical.empty()) extras["crs"]["vertical"] = crs.vertical;
    if (!crs.wkt.empty()) extras["crs"]["wkt"] = crs.wkt;
    return extras;
}

/// One node, or two: the inner one moves, in the input's units, and the outer one turns and scales.
Json GltfWriter::nodes() const {
    Json outer = Json::object();
    if (const Json rotation = rotation_to_y(frame_.up); !rotation.is_null())
        outer["rotation"] = rotation;
    const double scale = frame_.metres_per_unit;
    if (scale != 0.0 && scale != 1.0) outer["scale"] = {scale, scale, scale};
    Json inner = {{"mesh", 0}};
    if (placement_.has_translation()) {
        const Vec3d t = placement_.translation;
        inner["translation"] = {t.x, t.y, t.z};
    }
    Json nodes = Json::array();
    if (outer.empty() || !placement_.has_translation()) {
        outer.update(inner);
        nodes = {outer};
    } else {
        outer["children"] = Json::array({1});
        nodes = {outer, inner};
    }
    if (Json extras = this->extras(); !extras.empty())
        nodes[0]["extras"]["pointbake"] = std::move(extras);
    return nodes;
}

Json GltfWriter::texture_info(int image) const {
    const auto at = std::find(used_images_.begin(), used_images_.end(), image);
    return {{"index", at - used_images_.begin()}};
}

Json GltfWriter::material(Index index) const {
    const Material& m = materials_[index];
    const Look& look = looks_[index];
    Json pbr = Json::object();
    const auto in_range = [](double v) { return v > 0.0 ? std::min(v, 1.0) : 0.0; };
    if (m.base_color != std::array<double, 3>{1.0, 1.0, 1.0})
        pbr["baseColorFactor"] = {in_range(m.base_color[0]), in_range(m.base_color[1]),
                                  in_range(m.base_color[2]), 1.0};
    if (look.has_color_image) pbr["baseColorTexture"] = texture_info(m.color_image);
    pbr["metallicFactor"] = 0.0;
    pbr["roughnessFactor"] = 1.0;
    Json json = {{"name", m.name}, {"pbrMetallicRoughness", std::move(pbr)}};
    if (look.has_normal_image) json["normalTexture"] = texture_info(m.normal_image);
    if (m.is_double_sided) json["doubleSided"] = true;
    if (!look.is_lit) json["extensions"]["KHR_materials_unlit"] = Json::object();
    return json;
}

Json GltfWriter::sampler_of(std::size_t texture) const {
    const Image& image = model_.images[static_cast<std::size_t>(used_images_[texture])];
    const int wrap = image.repeats ? kRepeat : kClampToEdge;
    return {{"magFilter", kLinear},
            {"minFilter", image.has_mips ? kLinearMipmapLinear : kLinear},
            {"wrapS", wrap},
            {"wrapT", wrap}};
}

/// One for each way of sampling that is in use. Without a sampler textures repeat, and mip levels
/// made by the viewer mix patches.
Json GltfWriter::samplers(std::vector<std::size_t>& of_texture) const {
    Json json = Json::array();
    for (std::size_t i = 0; i < used_images_.size(); ++i) {
        const Json sampler = sampler_of(i);
        const auto known = std::find(json.begin(), json.end(), sampler);
        of_texture.push_back(static_cast<std::size_t>(known - json.begin()));
        if (known == json.end()) json.push_back(sampler);
    }
    return json;
}

Json GltfWriter::position_accessor(const MeshPart& part) const {
    Vec3f low = placement_.positions[vertex(part.corners.front())], high = low;
    for (const Index corner : part.corners) {
        const Vec3f p = placement_.positions[vertex(corner)];
        for (std::size_t k = 0; k < 3; ++k) {
            low[k] = std::min(low[k], p[k]);
            high[k] = std::max(high[k], p[k]);
        }
    }
    return {{"componentType", kFloat},
            {"type", "VEC3"},
            {"min", {low.x, low.y, low.z}},
            {"max", {high.x, high.y, high.z}}};
}

std::size_t GltfWriter::add_indices(const MeshPart& part) {
    const auto add = [&]<class T>(T, int component) {
        Json accessor = {{"componentType", component}, {"type", "SCALAR"}};
        return buffer_.add_accessor<T>(
            std::move(accessor), kElementArrayBuffer, part.indices.size(),
            [&part](std::size_t i) { return static_cast<T>(part.indices[i]); });
    };
    return part.corners.size() <= kMaxShortIndex + 1 ? add(std::uint16_t{}, kUnsignedShort)
                                                     : add(std::uint32_t{}, kUnsignedInt);
}

Json GltfWriter::primitive(const MeshPart& part, std::size_t material_index) {
    const Look& look = looks_[part.material];
    const std::size_t count = part.corners.size();
    Json attributes = Json::object();
    const auto add = [&]<class T>(const char* name, T, Json accessor, auto value) {
        attributes[name] = buffer_.add_accessor<T>(
            std::move(accessor), kArrayBuffer, count,
            [&part, value](std::size_t i) { return value(part.corners[i]); });
    };
    const auto floats = [](const char* type) {
        return Json{{"componentType", kFloat}, {"type", type}};
    };
    add("POSITION", Vec3f{}, position_accessor(part),
        [this](Index corner) { return placement_.positions[vertex(corner)]; });
    if (look.is_lit)
        add("NORMAL", Vec3f{}, floats("VEC3"),
            [this](Index corner) { return normals_[vertex(corner)]; });
    if (look.has_normal_image)
        add("TANGENT", Tangent4{}, floats("VEC4"), [this](Index corner) {
            const Vec3f t =
                unit_tangent(tangents_.directions[corner / 3], normals_[vertex(corner)]);
            return Tangent4{t.x, t.y, t.z, tangents_.signs[corner / 3] < 0 ? -1.0F : 1.0F};
        });
    if (look.has_uvs())
        add("TEXCOORD_0", Vec2f{}, floats("VEC2"),
            [this](Index corner) { return model_.mesh.uvs[corner / 3][corner % 3]; });
    if (look.has_vertex_colors)
        add("COLOR_0", Color4{},
            Json{{"componentType", kUnsignedShort}, {"normalized", true}, {"type", "VEC4"}},
            [this](Index corner) {
                const Vec3f c = to_linear(model_.mesh.colors[vertex(corner)]);
                const auto coded = [](float v) {
                    return static_cast<std::uint16_t>(v * 65535.0F + 0.5F);
                };
                return Color4{coded(c.x), coded(c.y), coded(c.z), 65535};
            });
    Json json = {{"attributes", std::move(attributes)}};
    json["indices"] = add_indices(part);
    json["material"] = material_index;
    return json;
}

/// Everything but the binary buffer. An entry of `images` says where each texture's image is.
Json GltfWriter::document(const std::vector<Json>& images, std::string_view buffer_uri) {
    Json materials = Json::array(), textures = Json::array();
    bool has_unlit = false;
    for (const MeshPart& part : parts_) {
        materials.push_back(material(part.material));
        has_unlit = has_unlit || !looks_[part.material].is_lit;
    }
    std::vector<std::size_t> of_texture;
    Json samplers = this->samplers(of_texture);
    for (std::size_t i = 0; i < images.size(); ++i)
        textures.push_back({{"sampler", of_texture[i]}, {"source", i}});

    Json json = {{"asset", {{"version", "2.0"}, {"generator", "pointbake " POINTBAKE_VERSION}}}};
    if (has_unlit) json["extensionsUsed"] = Json::array({"KHR_materials_unlit"});
    json["scene"] = 0;
    json["scenes"] = Json::array({Json{{"nodes", Json::array({0})}}});
    json["nodes"] = nodes();
    json["meshes"] = Json::array({Json{{"primitives", primitives_}}});
    json["materials"] = std::move(materials);
    if (!images.empty()) {
        json["textures"] = std::move(textures);
        json["samplers"] = std::move(samplers);
        json["images"] = images;
    }
    json["accessors"] = buffer_.accessors();
    json["bufferViews"] = buffer_.views();
    Json buffer = {{"byteLength", buffer_.num_bytes()}};
    if (!buffer_uri.empty()) buffer["uri"] = buffer_uri;
    json["buffers"] = Json::array({std::move(buffer)});
    return json;
}

void GltfWriter::report_image(std::size_t num_done) const {
    report_progress(context_, "write",
                    static_cast<double>(num_done) / static_cast<double>(used_images_.size() + 1));
}

void GltfWriter::write_glb(AtomicFile& file) {
    std::vector<Json> images;
    for (const int image : used_images_) {
        pngs_.push_back(encode_png(model_.images[static_cast<std::size_t>(image)], context_));
        images.push_back(
            {{"bufferView", buffer_.add_bytes(pngs_.back())}, {"mimeType", "image/png"}});
        report_image(images.size());
    }
    const std::string json = to_text(document(images, {}));
    const std::uint64_t total =
        kGlbHeaderBytes + 2 * kChunkHeaderBytes + aligned(json.size()) + buffer_.num_bytes();
    if (total > kMaxGlbBytes)
        fail(ErrorCode::kLimit,
             "cannot write '{}': it would have {} bytes and a GLB holds at most {}: write .gltf",
             path_.string(), total, kMaxGlbBytes);
    const auto word = [&](std::uint64_t v) { file.write_value(static_cast<std::uint32_t>(v)); };
    file.write("glTF");
    word(2);
    word(total);
    word(aligned(json.size()));
    file.write("JSON");
    file.write(json);
    write_padding(file, json.size(), ' ');
    word(buffer_.num_bytes());
    file.write(std::string_view("BIN\0", 4));
    buffer_.write(file);
}

void GltfWriter::write_separate(FileSet& files, AtomicFile& main) {
    const std::filesystem::path binary = sibling(path_, ".bin");
    buffer_.write(files.add(binary));
    std::vector<Json> images;
    for (const std::filesystem::path& png : image_paths(path_, used_images_.size())) {
        const auto image = static_cast<std::size_t>(used_images_[images.size()]);
        files.add(png).write(encode_png(model_.images[image], context_));
        images.push_back({{"uri", uri_of(png)}});
        report_image(images.size());
    }
    main.write(to_text(document(images, uri_of(binary))));
}

WriteReport GltfWriter::run() {
    FileSet files;
    AtomicFile& main = files.add(path_);  // first: what cannot be written is known at once
    WriteReport report;
    report.frame = frame_;
    report.global_shift = placement_.translation;
    report.num_draw_calls = parts_.size();
    for (const MeshPart& part : parts_) {
        report.num_vertices += part.corners.size();
        primitives_.push_back(primitive(part, primitives_.size()));
    }
    if (is_glb_)
        write_glb(main);
    else
        write_separate(files, main);
    add_prj(files, path_, frame_, report, context_);
    check_cancelled(context_);
    files.commit(report);
    return report;
}

}  // namespace

WriteReport write_gltf(const TexturedMesh& model, const std::filesystem::path& path,
                       const WriteOptions& options, const Context& context) {
    return GltfWriter(model, path, options, context).run();
}

}  // namespace pointbake
