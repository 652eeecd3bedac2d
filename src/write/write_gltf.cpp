// Based on [glTF20] and KHR_materials_unlit. Vertices are never laid out in
// memory: they are looked up in the model while they are written.
#include "write/write_gltf.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/color.h"
#include "core/message.h"
#include "write/draco_coding.h"
#include "write/encode_image.h"
#include "write/file_set.h"
#include "write/frame.h"
#include "write/gltf_buffer.h"
#include "write/look.h"
#include "write/placement.h"
#include "write/split.h"
#include "write/tangents.h"

namespace pointbake {
namespace {

constexpr int kArrayBuffer = 34962, kElementArrayBuffer = 34963;
constexpr int kUnsignedShort = 5123, kUnsignedInt = 5125, kFloat = 5126;
constexpr int kLinear = 9729, kLinearMipmapLinear = 9987, kClampToEdge = 33071, kRepeat = 10497;
constexpr std::size_t kMaxShortIndex = 65534;  // 65535 restarts primitives
constexpr int kUnitExponent = -15;             // grid of compressed unit vectors
constexpr std::uint64_t kMaxGlbBytes = ~std::uint32_t{0};
constexpr std::uint64_t kGlbHeaderBytes = 12, kChunkHeaderBytes = 8;

/// The turn that makes an axis of the input point along +y. Never mirrored.
Json rotation_to_y(UpAxis up) {
    const double half = std::sqrt(0.5);
    if (up == UpAxis::kX) return {0.0, 0.0, half, half};
    if (up == UpAxis::kZ) return {-half, 0.0, 0.0, half};
    if (up == UpAxis::kMinusY) return {1.0, 0.0, 0.0, 0.0};
    return {};
}

/// Indices of a part of so many vertices.
Json index_accessor(std::size_t num_vertices) {
    return {{"componentType", num_vertices <= kMaxShortIndex + 1 ? kUnsignedShort : kUnsignedInt},
            {"type", "SCALAR"}};
}

/// The grid of compressed texture coordinates: a 256th of a texel of the largest usual pages, or
/// what leaves room for 2^22 steps.
int uv_exponent(const Mesh& mesh) {
    constexpr int kFinest = -20, kRoom = 22;
    double far = 0.0;
    for (const auto& corners : mesh.uvs)
        for (const Vec2f uv : corners)
            far = std::max(
                {far, static_cast<double>(std::fabs(uv.x)), static_cast<double>(std::fabs(uv.y))});
    return far > 0.0 ? std::max(kFinest, std::ilogb(far) + 1 - kRoom) : kFinest;
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
    /// A primitive on its way; the last two are for Draco.
    struct Draft {
        const MeshPart& part;
        Json attributes;
        std::vector<DracoAttribute> packed;
        std::vector<Json> accessors;
    };
    template <class T, class Value>
    void add_attribute(Draft& draft, const char* name, Json accessor, std::optional<int> exponent,
                       Value value);
    std::size_t add_indices(const MeshPart& part);
    void add_draco(Draft& draft, Json& primitive);
    void use_image(int image);
    void use_extension(std::string_view name, bool is_required);
    Json document(const std::vector<Json>& images, std::string_view buffer_uri);

    void write_glb(AtomicFile& file);
    void write_separate(FileSet& files, AtomicFile& main);
    void report_image(std::size_t num_done) const;

    const Image& image_of(std::size_t texture) const {
        return model_.images[static_cast<std::size_t>(used_images_[texture])];
    }
    bool is_webp(std::size_t texture) const {
        return file_kind(image_of(texture)).mime_type == "image/webp";
    }
    Index vertex(Index corner) const { return triangles_[corner / 3][corner % 3]; }

    const TexturedMesh& model_;
    const std::filesystem::path& path_;
    Frame frame_;
    Compression compress_;
    const Context& context_;
    bool is_glb_;

    std::vector<Material> materials_;
    std::vector<Look> looks_;  // one per material
    Placement32 placement_;
    int uv_exponent_ = 0;
    std::vector<Triangle> triangles_;
    std::vector<Vec3f> normals_;  // empty if nothing is lit
    Tangents tangents_;           // empty if there is no normal map
    std::vector<MeshPart> parts_;
    std::vector<int> used_images_;                     // the image of each texture
    std::vector<std::vector<std::byte>> image_files_;  // of a GLB
    std::vector<std::vector<std::byte>> draco_views_;
    GltfBuffer buffer_;
    Json primitives_ = Json::array();
    Json extensions_used_ = Json::array(), extensions_required_ = Json::array();
};

GltfWriter::GltfWriter(const TexturedMesh& model, const std::filesystem::path& path,
                       const WriteOptions& options, const Context& context)
    : model_(model),
      path_(path),
      frame_(settled_frame(model.frame, options)),
      compress_(options.compress),
      context_(context),
      is_glb_(path.extension().string().size() == 4),  // else .gltf
      materials_(model.materials),
      buffer_(context, options.compress == Compression::kMeshopt) {
    if (materials_.empty()) materials_.emplace_back();
    const Mesh& mesh = model.mesh;
    placement_ = compress_ == Compression::kNone ? place_as_floats(mesh.positions, mesh.triangles)
                                                 : place_on_grid(mesh.positions, mesh.triangles);
    uv_exponent_ = uv_exponent(mesh);
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
    if (compress_ == Compression::kMeshopt) {
        for (MeshPart& part : parts_) reorder_in_place(part);
        use_extension("EXT_meshopt_compression", true);
    }
    if (compress_ == Compression::kDraco) use_extension("KHR_draco_mesh_compression", true);
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

void GltfWriter::use_extension(std::string_view name, bool is_required) {
    for (Json* list : {&extensions_used_, is_required ? &extensions_required_ : nullptr})
        if (list && std::find(list->begin(), list->end(), name) == list->end())
            list->push_back(name);
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
    const Image& image = image_of(texture);
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

template <class T, class Value>
void GltfWriter::add_attribute(Draft& draft, const char* name, Json accessor,
                               std::optional<int> exponent, Value value) {
    const MeshPart& part = draft.part;
    const std::size_t count = part.corners.size();
    const auto at = [&part, value](std::size_t i) { return value(part.corners[i]); };
    if (compress_ != Compression::kDraco) {
        draft.attributes[name] =
            buffer_.add_attribute<T>(std::move(accessor), kArrayBuffer, count, exponent, at);
        return;
    }
    using Kind = DracoAttribute::Kind;
    const Kind kind = !exponent                            ? Kind::kExact16
                      : std::string_view(name) == "NORMAL" ? Kind::kUnit
                                                           : Kind::kGrid;
    constexpr std::size_t component_bytes = std::is_same_v<T, Color4> ? 2 : sizeof(float);
    draft.packed.push_back({name, kind, sizeof(T) / component_bytes, {}, exponent.value_or(0)});
    for (std::size_t i = 0; i < count; ++i) {
        const T element = at(i);
        const auto bytes = std::as_bytes(std::span<const T>(&element, 1));
        draft.packed.back().elements.insert(draft.packed.back().elements.end(), bytes.begin(),
                                            bytes.end());
    }
    draft.accessors.push_back(std::move(accessor));
}

std::size_t GltfWriter::add_indices(const MeshPart& part) {
    return part.corners.size() <= kMaxShortIndex + 1
               ? buffer_.add_indices<std::uint16_t>(index_accessor(part.corners.size()),
                                                    kElementArrayBuffer, part.indices)
               : buffer_.add_indices<std::uint32_t>(index_accessor(part.corners.size()),
                                                    kElementArrayBuffer, part.indices);
}

/// Attributes and indices in one view; the accessors only describe what a decoder finds.
void GltfWriter::add_draco(Draft& draft, Json& primitive) {
    DracoMesh packed = draco_mesh(draft.part.indices, draft.packed, draft.part.corners.size());
    check_cancelled(context_);
    Json ids = Json::object();
    for (std::size_t i = 0; i < draft.packed.size(); ++i) {
        const std::string& name = draft.packed[i].name;
        ids[name] = packed.ids[i];
        draft.attributes[name] =
            buffer_.add_empty_accessor(std::move(draft.accessors[i]), packed.num_vertices);
    }
    draco_views_.push_back(std::move(packed.bytes));
    primitive["attributes"] = std::move(draft.attributes);
    primitive["indices"] =
        buffer_.add_empty_accessor(index_accessor(packed.num_vertices), 3 * packed.num_triangles);
    primitive["extensions"]["KHR_draco_mesh_compression"] = {
        {"bufferView", buffer_.add_bytes(draco_views_.back())}, {"attributes", std::move(ids)}};
}

Json GltfWriter::primitive(const MeshPart& part, std::size_t material_index) {
    const Look& look = looks_[part.material];
    Draft draft{part, Json::object(), {}, {}};
    const auto floats = [](const char* type) {
        return Json{{"componentType", kFloat}, {"type", type}};
    };
    add_attribute<Vec3f>(draft, "POSITION", position_accessor(part), placement_.exponent,
                         [this](Index corner) { return placement_.positions[vertex(corner)]; });
    if (look.is_lit)
        add_attribute<Vec3f>(draft, "NORMAL", floats("VEC3"), kUnitExponent,
                             [this](Index corner) { return normals_[vertex(corner)]; });
    if (look.has_normal_image)
        add_attribute<Tangent4>(
            draft, "TANGENT", floats("VEC4"), kUnitExponent, [this](Index corner) {
                const Vec3f t =
                    unit_tangent(tangents_.directions[corner / 3], normals_[vertex(corner)]);
                return Tangent4{t.x, t.y, t.z, tangents_.signs[corner / 3] < 0 ? -1.0F : 1.0F};
            });
    if (look.has_uvs())
        add_attribute<Vec2f>(
            draft, "TEXCOORD_0", floats("VEC2"), uv_exponent_,
            [this](Index corner) { return model_.mesh.uvs[corner / 3][corner % 3]; });
    if (look.has_vertex_colors)
        add_attribute<Color4>(
            draft, "COLOR_0",
            Json{{"componentType", kUnsignedShort}, {"normalized", true}, {"type", "VEC4"}},
            std::nullopt, [this](Index corner) {
                const Vec3f c = to_linear(model_.mesh.colors[vertex(corner)]);
                const auto coded = [](float v) {
                    return static_cast<std::uint16_t>(v * 65535.0F + 0.5F);
                };
                return Color4{coded(c.x), coded(c.y), coded(c.z), 65535};
            });
    Json json = Json::object();
    if (compress_ == Compression::kDraco) {
        add_draco(draft, json);
    } else {
        json["attributes"] = std::move(draft.attributes);
        json["indices"] = add_indices(part);
    }
    json["material"] = material_index;
    return json;
}

/// Everything but the binary buffer. An entry of `images` says where each texture's image is.
Json GltfWriter::document(const std::vector<Json>& images, std::string_view buffer_uri) {
    Json materials = Json::array(), textures = Json::array();
    for (const MeshPart& part : parts_) {
        materials.push_back(material(part.material));
        if (!looks_[part.material].is_lit) use_extension("KHR_materials_unlit", false);
    }
    std::vector<std::size_t> of_texture;
    Json samplers = this->samplers(of_texture);
    for (std::size_t i = 0; i < images.size(); ++i) {
        Json texture = {{"sampler", of_texture[i]}};
        (is_webp(i) ? texture["extensions"]["EXT_texture_webp"] : texture)["source"] = i;
        if (is_webp(i)) use_extension("EXT_texture_webp", true);
        textures.push_back(std::move(texture));
    }

    Json json = {{"asset", {{"version", "2.0"}, {"generator", "pointbake " POINTBAKE_VERSION}}}};
    if (!extensions_used_.empty()) json["extensionsUsed"] = extensions_used_;
    if (!extensions_required_.empty()) json["extensionsRequired"] = extensions_required_;
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
    if (compress_ == Compression::kMeshopt)
        json["buffers"].push_back(
            {{"byteLength", buffer_.num_unpacked_bytes()},
             {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}});
    return json;
}

void GltfWriter::report_image(std::size_t num_done) const {
    report_progress(context_, "write",
                    static_cast<double>(num_done) / static_cast<double>(used_images_.size() + 1));
}

void GltfWriter::write_glb(AtomicFile& file) {
    std::vector<Json> images;
    for (std::size_t i = 0; i < used_images_.size(); ++i) {
        image_files_.push_back(image_file(image_of(i), context_));
        images.push_back({{"bufferView", buffer_.add_bytes(image_files_.back())},
                          {"mimeType", file_kind(image_of(i)).mime_type}});
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
    for (const std::filesystem::path& path : image_paths(path_, model_, used_images_)) {
        files.add(path).write(image_file(image_of(images.size()), context_));
        images.push_back({{"uri", uri_of(path)}});
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
    report.has_transform = report.has_translation = true;
    report.num_draw_calls = parts_.size();
    for (const MeshPart& part : parts_) {
        report.num_vertices += part.corners.size();
        primitives_.push_back(primitive(part, primitives_.size()));
    }
    if (is_glb_)
        write_glb(main);
    else
        write_separate(files, main);
    commit_with_prj(files, path_, report, context_);
    return report;
}

}  // namespace

WriteReport write_gltf(const TexturedMesh& model, const std::filesystem::path& path,
                       const WriteOptions& options, const Context& context) {
    return GltfWriter(model, path, options, context).run();
}

}  // namespace pointbake
