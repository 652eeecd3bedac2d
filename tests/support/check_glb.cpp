// Based on the glTF 2.0 specification, sections 3 and 4.
#include "support/check_glb.h"

#include <fmt/format.h>
#include <sys/wait.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <memory>
#include <optional>
#include <set>
#include <span>

namespace pointbake {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using Bytes = std::vector<std::byte>;
using Matrix = std::array<std::array<double, 4>, 4>;

constexpr int kClampToEdge = 33071, kRepeat = 10497;
constexpr double kUnitTolerance = 1e-5;  // floats of a normalised vector are within 1e-7

/// Ends the check of a file that cannot be understood any further.
struct Broken {
    std::string what;
};

template <class... Args>
[[noreturn]] void broken(fmt::format_string<Args...> format, Args&&... args) {
    throw Broken{fmt::format(format, std::forward<Args>(args)...)};
}

Bytes read_bytes(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) broken("cannot open {}", path.string());
    const std::vector<char> chars((std::istreambuf_iterator<char>(file)), {});
    Bytes bytes(chars.size());
    std::memcpy(bytes.data(), chars.data(), chars.size());
    return bytes;
}

std::uint32_t word_at(const Bytes& bytes, std::size_t at) {
    if (at + 4 > bytes.size()) broken("the file ends at byte {} of {}", bytes.size(), at + 4);
    std::uint32_t word;
    std::memcpy(&word, bytes.data() + at, 4);
    return word;
}

std::string decoded(std::string_view uri) {
    std::string out;
    for (std::size_t i = 0; i < uri.size(); ++i) {
        if (uri[i] == '%' && i + 2 < uri.size()) {
            out += static_cast<char>(std::stoi(std::string(uri.substr(i + 1, 2)), nullptr, 16));
            i += 2;
        } else {
            out += uri[i];
        }
    }
    return out;
}

Matrix identity() {
    Matrix m{};
    for (std::size_t i = 0; i < 4; ++i) m[i][i] = 1.0;
    return m;
}

Matrix multiplied(const Matrix& a, const Matrix& b) {
    Matrix m{};
    for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = 0; j < 4; ++j)
            for (std::size_t k = 0; k < 4; ++k) m[i][j] += a[i][k] * b[k][j];
    return m;
}

Vec3d transformed(const Matrix& m, Vec3d p) {
    Vec3d out;
    for (std::size_t i = 0; i < 3; ++i)
        out[i] = m[i][0] * p.x + m[i][1] * p.y + m[i][2] * p.z + m[i][3];
    return out;
}

class GlbChecker {
 public:
    explicit GlbChecker(const fs::path& path) : path_(path) {}

    GlbContents run() {
        try {
            read_container();
            check_top();
            read_views();
            read_images();
            check_materials();
            walk_scene();
            check_use();
        } catch (const Broken& b) {
            contents_.problems.push_back(b.what);
        } catch (const Json::exception& e) {
            contents_.problems.push_back(e.what());
        }
        return std::move(contents_);
    }

 private:
    template <class... Args>
    void expect(bool holds, fmt::format_string<Args...> format, Args&&... args) {
        if (!holds) contents_.problems.push_back(fmt::format(format, std::forward<Args>(args)...));
    }

    const Json& json() const { return contents_.document; }
    const Json& array(const char* key) const {
        static const Json kEmpty = Json::array();
        return json().contains(key) ? json().at(key) : kEmpty;
    }
    /// Element `index` of a top-level array; remembers that it is used.
    const Json& element(const char* key, std::size_t index) {
        const Json& all = array(key);
        if (index >= all.size()) broken("{} {} of {} is used", key, index, all.size());
        used_.insert({key, index});
        return all.at(index);
    }

    void read_container();
    void read_chunks(const Bytes& file);
    void check_top();
    void read_views();
    void read_images();
    void check_materials();
    void check_texture(const Json& info);
    void check_wrap(const Json& material, const GlbPrimitive& p);
    void walk_scene();
    void walk_node(std::size_t index, const Matrix& parent);
    Matrix local_matrix(const Json& node);
    void read_primitive(const Json& primitive, const Matrix& world);
    void check_attributes(const Json& primitive, const GlbPrimitive& p);
    void check_use();

    struct Accessor {
        const Json* json = nullptr;
        std::size_t count = 0, width = 0, component_bytes = 0;
        int component = 0;
        std::span<const std::byte> bytes;
    };
    Accessor accessor(std::size_t index, int target);
    template <class T, std::size_t N>
    std::vector<std::array<T, N>> values(const Accessor& a, int component);
    void check_bounds(const Json& json, const std::vector<std::array<float, 3>>& values);

    fs::path path_;
    bool is_glb_ = false;
    Bytes buffer_;
    std::vector<std::span<const std::byte>> views_;
    std::set<std::pair<std::string, std::size_t>> used_;
    std::set<std::size_t> visiting_;
    GlbContents contents_;
};

void GlbChecker::read_container() {
    const Bytes file = read_bytes(path_);
    is_glb_ = file.size() >= 4 && word_at(file, 0) == 0x46546C67;
    if (is_glb_) {
        read_chunks(file);
    } else {
        contents_.document = Json::parse(reinterpret_cast<const char*>(file.data()),
                                         reinterpret_cast<const char*>(file.data()) + file.size());
    }
    const Json& buffers = array("buffers");
    expect(buffers.size() == 1, "{} buffers", buffers.size());
    const Json& buffer = element("buffers", 0);
    if (!is_glb_)
        buffer_ = read_bytes(path_.parent_path() / decoded(buffer.at("uri").get<std::string>()));
    else
        expect(!buffer.contains("uri"), "the buffer of a GLB has a uri");
    const auto length = buffer.at("byteLength").get<std::size_t>();
    if (length > buffer_.size()) broken("the buffer has {} of {} bytes", buffer_.size(), length);
    expect(buffer_.size() - length < 4, "{} bytes behind the buffer", buffer_.size() - length);
}

void GlbChecker::read_chunks(const Bytes& file) {
    expect(word_at(file, 4) == 2, "version {}", word_at(file, 4));
    expect(word_at(file, 8) == file.size(), "length {} of {}", word_at(file, 8), file.size());
    const std::size_t json_bytes = word_at(file, 12);
    expect(json_bytes % 4 == 0, "the JSON chunk's length {} is no multiple of 4", json_bytes);
    expect(word_at(file, 16) == 0x4E4F534A, "the first chunk is not JSON");
    if (20 + json_bytes > file.size()) broken("the JSON chunk ends behind the file");
    const char* const text = reinterpret_cast<const char*>(file.data()) + 20;
    contents_.document = Json::parse(text, text + json_bytes);
    const std::size_t at = 20 + json_bytes;
    const std::size_t bin_bytes = word_at(file, at);
    expect(bin_bytes % 4 == 0, "the BIN chunk's length {} is no multiple of 4", bin_bytes);
    expect(word_at(file, at + 4) == 0x004E4942, "the second chunk is not BIN");
    if (at + 8 + bin_bytes != file.size()) broken("the BIN chunk does not end with the file");
    buffer_.assign(file.begin() + static_cast<std::ptrdiff_t>(at + 8), file.end());
}

void GlbChecker::check_top() {
    const Json& asset = json().at("asset");
    expect(asset.at("version") == "2.0", "asset.version is not 2.0");
    expect(asset.value("generator", "").starts_with("pointbake "), "no asset.generator");
    std::set<std::string> in_use;
    for (const Json& m : array("materials"))
        if (m.contains("extensions"))
            for (const auto& [name, value] : m.at("extensions").items()) in_use.insert(name);
    std::set<std::string> declared;
    for (const Json& name : array("extensionsUsed")) declared.insert(name.get<std::string>());
    expect(in_use == declared, "extensionsUsed is not what is used");
    for (const char* key : {"extensionsUsed", "materials", "textures", "samplers", "images"})
        expect(!json().contains(key) || !json().at(key).empty(), "{} is empty", key);
}

void GlbChecker::read_views() {
    std::size_t end = 0;
    for (const Json& view : array("bufferViews")) {
        const auto offset = view.value("byteOffset", std::size_t{0});
        const auto length = view.at("byteLength").get<std::size_t>();
        if (view.at("buffer") != 0) broken("a view of buffer {}", view.at("buffer").dump());
        if (length == 0) broken("a view of 0 bytes");
        if (offset > buffer_.size() || length > buffer_.size() - offset)
            broken("a view of bytes {} + {} of {}", offset, length, buffer_.size());
        expect(offset % 4 == 0, "a view at byte {}", offset);
        expect(offset >= end && offset - end < 4, "a view at byte {} behind one that ends at {}",
               offset, end);
        expect(!view.contains("byteStride"), "a view with a stride");
        end = offset + length;
        views_.push_back(std::span(buffer_).subspan(offset, length));
    }
    expect(buffer_.size() - end < 4, "{} bytes behind the last view", buffer_.size() - end);
}

void GlbChecker::read_images() {
    constexpr std::array<unsigned char, 8> kSignature = {0x89, 'P',  'N',  'G',
                                                         '\r', '\n', 0x1a, '\n'};
    for (const Json& image : array("images")) {
        Bytes bytes;
        if (image.contains("bufferView")) {
            const auto view = image.at("bufferView").get<std::size_t>();
            expect(!element("bufferViews", view).contains("target"),
                   "an image's view has a target");
            expect(image.at("mimeType") == "image/png", "an image without mimeType image/png");
            bytes.assign(views_.at(view).begin(), views_.at(view).end());
        } else {
            expect(!is_glb_, "an image of a GLB lies outside");
            bytes = read_bytes(path_.parent_path() / decoded(image.at("uri").get<std::string>()));
        }
        expect(bytes.size() > 57 && std::memcmp(bytes.data(), kSignature.data(), 8) == 0,
               "an image is no PNG");
        contents_.images.push_back(std::move(bytes));
    }
}

void GlbChecker::check_texture(const Json& info) {
    const Json& texture = element("textures", info.at("index").get<std::size_t>());
    element("images", texture.at("source").get<std::size_t>());
    const Json& sampler = element("samplers", texture.at("sampler").get<std::size_t>());
    const Json& wrap = sampler.at("wrapS");
    expect(wrap == sampler.at("wrapT") && (wrap == kClampToEdge || wrap == kRepeat),
           "a sampler wraps by {} and {}", wrap.dump(), sampler.at("wrapT").dump());
    expect(sampler.at("magFilter") == 9729, "a sampler's magFilter is not LINEAR");
    expect(sampler.at("minFilter") == 9729 || sampler.at("minFilter") == 9987,
           "a sampler's minFilter is {}", sampler.at("minFilter").dump());
}

void GlbChecker::check_materials() {
    for (const Json& m : array("materials")) {
        const Json& pbr = m.at("pbrMetallicRoughness");
        expect(pbr.at("metallicFactor") == 0.0 && pbr.at("roughnessFactor") == 1.0,
               "a material that shines");
        if (pbr.contains("baseColorTexture")) check_texture(pbr.at("baseColorTexture"));
        if (m.contains("normalTexture")) check_texture(m.at("normalTexture"));
        if (!pbr.contains("baseColorFactor")) continue;
        const auto factor = pbr.at("baseColorFactor").get<std::array<double, 4>>();
        for (const double f : factor) expect(f >= 0.0 && f <= 1.0, "a colour factor of {}", f);
    }
}

void GlbChecker::walk_scene() {
    const Json& scene = element("scenes", json().at("scene").get<std::size_t>());
    for (const Json& node : scene.at("nodes")) walk_node(node.get<std::size_t>(), identity());
}

void GlbChecker::walk_node(std::size_t index, const Matrix& parent) {
    const Json& node = element("nodes", index);
    if (!visiting_.insert(index).second) broken("node {} is its own ancestor", index);
    const Matrix world = multiplied(parent, local_matrix(node));
    if (node.contains("mesh"))
        for (const Json& p : element("meshes", node.at("mesh").get<std::size_t>()).at("primitives"))
            read_primitive(p, world);
    if (node.contains("children"))
        for (const Json& child : node.at("children")) walk_node(child.get<std::size_t>(), world);
    visiting_.erase(index);
}

Matrix GlbChecker::local_matrix(const Json& node) {
    expect(!node.contains("matrix"), "a node with a matrix");
    const auto t = node.value("translation", std::array<double, 3>{0, 0, 0});
    const auto [x, y, z, w] = node.value("rotation", std::array<double, 4>{0, 0, 0, 1});
    const auto s = node.value("scale", std::array<double, 3>{1, 1, 1});
    expect(std::fabs(x * x + y * y + z * z + w * w - 1.0) < 1e-12, "a rotation is not unit");
    expect(s[0] > 0.0 && s[1] > 0.0 && s[2] > 0.0, "a scale mirrors or flattens");
    const double r[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
                            {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
                            {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}};
    Matrix m = identity();
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) m[i][j] = r[i][j] * s[j];
        m[i][3] = t[i];
    }
    return m;
}

GlbChecker::Accessor GlbChecker::accessor(std::size_t index, int target) {
    Accessor a;
    a.json = &element("accessors", index);
    a.count = a.json->at("count").get<std::size_t>();
    a.component = a.json->at("componentType").get<int>();
    a.component_bytes = a.component == 5126 || a.component == 5125   ? 4
                        : a.component == 5123 || a.component == 5122 ? 2
                                                                     : 1;
    const auto type = a.json->at("type").get<std::string>();
    a.width = type == "SCALAR" ? 1 : static_cast<std::size_t>(type.at(3) - '0');
    const auto view = a.json->at("bufferView").get<std::size_t>();
    expect(element("bufferViews", view).value("target", 0) == target,
           "the view of accessor {} has not the target {}", index, target);
    const auto offset = a.json->value("byteOffset", std::size_t{0});
    expect(offset % a.component_bytes == 0, "accessor {} begins at byte {}", index, offset);
    const std::size_t needed = a.count * a.width * a.component_bytes;
    if (a.count == 0 || offset + needed > views_.at(view).size())
        broken("accessor {} of {} elements in {} bytes", index, a.count, views_.at(view).size());
    expect(offset + needed == views_.at(view).size(), "accessor {} leaves bytes over", index);
    a.bytes = views_.at(view).subspan(offset, needed);
    return a;
}

template <class T, std::size_t N>
std::vector<std::array<T, N>> GlbChecker::values(const Accessor& a, int component) {
    if (a.component != component || a.width != N)
        broken("an accessor of {} x {} instead of {} x {}", a.width, a.component, N, component);
    std::vector<std::array<T, N>> out(a.count);
    std::memcpy(out.data(), a.bytes.data(), a.bytes.size());
    if constexpr (std::is_floating_point_v<T>)
        for (const auto& v : out)
            for (const T x : v)
                if (!std::isfinite(x)) broken("a value that is not finite");
    return out;
}

void GlbChecker::check_bounds(const Json& accessor_json,
                              const std::vector<std::array<float, 3>>& points) {
    const auto low = accessor_json.at("min").get<std::array<double, 3>>();
    const auto high = accessor_json.at("max").get<std::array<double, 3>>();
    for (std::size_t k = 0; k < 3; ++k) {
        double least = HUGE_VAL, most = -HUGE_VAL;
        for (const auto& p : points) {
            least = std::min(least, static_cast<double>(p[k]));
            most = std::max(most, static_cast<double>(p[k]));
        }
        expect(low[k] == least, "POSITION min[{}] is {} instead of {}", k, low[k], least);
        expect(high[k] == most, "POSITION max[{}] is {} instead of {}", k, high[k], most);
    }
}

void GlbChecker::read_primitive(const Json& primitive, const Matrix& world) {
    constexpr int kVertices = 34962, kIndices = 34963;
    constexpr int kUnsignedShort = 5123, kUnsignedInt = 5125, kFloat = 5126;
    GlbPrimitive p;
    p.material = primitive.at("material").get<std::size_t>();
    element("materials", p.material);
    const Json& attributes = primitive.at("attributes");
    const auto attribute = [&](const char* name) -> std::optional<Accessor> {
        if (!attributes.contains(name)) return std::nullopt;
        return accessor(attributes.at(name).get<std::size_t>(), kVertices);
    };
    const std::optional<Accessor> position = attribute("POSITION");
    if (!position) broken("a primitive without POSITION");
    const auto points = values<float, 3>(*position, kFloat);
    check_bounds(*position->json, points);
    for (const auto& [x, y, z] : points) {
        p.stored_positions.push_back({x, y, z});
        p.positions.push_back(transformed(world, vec_cast<double>(Vec3f{x, y, z})));
    }
    if (const auto a = attribute("TEXCOORD_0"))
        for (const auto& [u, v] : values<float, 2>(*a, kFloat)) p.uvs.push_back({u, v});
    if (const auto a = attribute("NORMAL"))
        for (const auto& [x, y, z] : values<float, 3>(*a, kFloat)) p.normals.push_back({x, y, z});
    if (const auto a = attribute("TANGENT")) p.tangents = values<float, 4>(*a, kFloat);
    if (const auto a = attribute("COLOR_0")) {
        expect(a->json->value("normalized", false), "COLOR_0 is not normalized");
        p.colors = values<std::uint16_t, 4>(*a, kUnsignedShort);
    }
    const Accessor indices = accessor(primitive.at("indices").get<std::size_t>(), kIndices);
    p.index_bytes = static_cast<int>(indices.component_bytes);
    std::vector<std::uint32_t> list;
    if (indices.component == kUnsignedShort)
        for (const auto& [i] : values<std::uint16_t, 1>(indices, kUnsignedShort)) list.push_back(i);
    else
        for (const auto& [i] : values<std::uint32_t, 1>(indices, kUnsignedInt)) list.push_back(i);
    expect(list.size() % 3 == 0, "{} indices", list.size());
    for (std::size_t i = 0; i + 2 < list.size(); i += 3)
        p.triangles.push_back({list[i], list[i + 1], list[i + 2]});
    check_attributes(primitive, p);
    contents_.primitives.push_back(std::move(p));
}

void GlbChecker::check_attributes(const Json& primitive, const GlbPrimitive& p) {
    const std::size_t n = p.positions.size();
    for (const std::size_t size :
         {p.uvs.size(), p.normals.size(), p.tangents.size(), p.colors.size()})
        expect(size == 0 || size == n, "an attribute of {} values for {} vertices", size, n);
    for (const auto& [name, value] : primitive.at("attributes").items())
        expect(std::set<std::string>{"POSITION", "NORMAL", "TANGENT", "TEXCOORD_0", "COLOR_0"}
                   .contains(name),
               "an attribute {}", name);

    std::vector<char> is_used(n, 0);
    const std::uint32_t restart = p.index_bytes == 2 ? 0xffffU : 0xffffffffU;
    for (const auto& t : p.triangles) {
        for (const std::uint32_t v : t) {
            if (v >= n || v == restart) broken("index {} of {} vertices", v, n);
            is_used[v] = 1;
        }
        expect(t[0] != t[1] && t[1] != t[2] && t[2] != t[0], "a triangle repeats a vertex");
    }
    expect(std::find(is_used.begin(), is_used.end(), 0) == is_used.end(), "a vertex is not used");

    for (const Vec3f& v : p.normals)
        expect(std::fabs(static_cast<double>(length(v)) - 1.0) < kUnitTolerance,
               "a normal of length {}", length(v));
    for (const auto& t : p.tangents) {
        expect(
            std::fabs(static_cast<double>(length(Vec3f{t[0], t[1], t[2]})) - 1.0) < kUnitTolerance,
            "a tangent that is not unit");
        expect(t[3] == 1.0F || t[3] == -1.0F, "a tangent's sign {}", t[3]);
    }
    const Json& material = array("materials").at(p.material);
    const bool is_lit = !material.contains("extensions");
    const bool has_map = material.contains("normalTexture");
    const bool has_texture =
        has_map || material.at("pbrMetallicRoughness").contains("baseColorTexture");
    expect(is_lit == !p.normals.empty(), "normals and lighting do not go together");
    expect(has_map == !p.tangents.empty(), "tangents and normal map do not go together");
    expect(has_texture == !p.uvs.empty(), "texture and texture coordinates do not go together");
    check_wrap(material, p);
}

// Pages repeat only where texture coordinates leave them.
void GlbChecker::check_wrap(const Json& material, const GlbPrimitive& p) {
    const Json& pbr = material.at("pbrMetallicRoughness");
    const bool has_map = material.contains("normalTexture");
    if (!has_map && !pbr.contains("baseColorTexture")) return;
    const Json& info = has_map ? material.at("normalTexture") : pbr.at("baseColorTexture");
    const auto texture = info.at("index").get<std::size_t>();
    const auto sampler = array("textures").at(texture).at("sampler").get<std::size_t>();
    const bool repeats = array("samplers").at(sampler).at("wrapS") == kRepeat;
    const bool leaves = std::any_of(p.uvs.begin(), p.uvs.end(), [](Vec2f uv) {
        return std::min(uv.x, uv.y) < -1e-4F || std::max(uv.x, uv.y) > 1.0F + 1e-4F;
    });
    expect(repeats == leaves, "a sampler repeats: {}; texture coordinates outside 0..1: {}",
           repeats, leaves);
}

void GlbChecker::check_use() {
    for (const char* key : {"scenes", "nodes", "meshes", "materials", "textures", "samplers",
                            "images", "accessors", "bufferViews", "buffers"})
        for (std::size_t i = 0; i < array(key).size(); ++i)
            expect(used_.contains({key, i}), "{} {} is not used", key, i);
}

std::string quoted(const std::string& text) {
    std::string out = "'";
    for (const char c : text) {
        if (c == '\'')
            out += "'\\''";
        else
            out += c;
    }
    out += '\'';
    return out;
}

}  // namespace

GlbContents check_glb(const fs::path& path) { return GlbChecker(path).run(); }

ValidatorResult run_checker(const std::string& checker, const std::vector<fs::path>& files) {
    std::string command = checker;
    for (const fs::path& file : files) command += fmt::format(" {}", quoted(file.string()));
    ValidatorResult result;
    std::FILE* const pipe = ::popen((command + " 2>&1").c_str(), "r");
    if (pipe == nullptr) {
        result.output = "no shell to start it with";
        return result;
    }
    std::array<char, 4096> chunk;
    while (const std::size_t n = std::fread(chunk.data(), 1, chunk.size(), pipe))
        result.output.append(chunk.data(), n);
    const int status = ::pclose(pipe);
    const int code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    // 127: the shell found no such program. 3: the package is missing.
    result.is_available = code != 127 && code != 3;
    result.is_clean = code == 0;
    return result;
}

ValidatorResult run_gltf_validator(const fs::path& script_folder,
                                   const std::vector<fs::path>& files) {
    return run_checker("node " + quoted((script_folder / "validate_gltf.mjs").string()), files);
}

ValidatorResult run_reader(const fs::path& script_folder, const std::string& reader,
                           const std::vector<fs::path>& files) {
    const char* const python = std::getenv("POINTBAKE_PYTHON");
    return run_checker(fmt::format("{} {} {}", quoted(python ? python : "python3"),
                                   quoted((script_folder / "check_models.py").string()), reader),
                       files);
}

}  // namespace pointbake
