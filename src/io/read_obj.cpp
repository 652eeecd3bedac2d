// Positions, texture coordinates, polygons, materials with their colour and its texture; other
// statements are skipped. A material's Kd is taken as an sRGB-coded colour, and only where there is
// no map_Kd: that is how most programs write and show it.
#include "io/read_obj.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "core/color.h"
#include "core/mapped_file.h"
#include "core/message.h"
#include "core/parallel.h"
#include "io/mesh_builder.h"
#include "io/text_numbers.h"

namespace pointbake {
namespace {

constexpr std::size_t kLinesPerPoll = std::size_t{1} << 16;
// Vertex colours up to here are meant to be in [0, 1]; above, the scale is 8 bit.
constexpr double kUnitColorMax = 1.5;

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

std::string_view as_text(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::string_view trimmed(std::string_view text) {
    while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
    while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
    return text;
}

std::string_view take_word(std::string_view& line) {
    line = trimmed(line);
    const std::size_t end = std::min(line.find_first_of(" \t\r"), line.size());
    const std::string_view word = line.substr(0, end);
    line.remove_prefix(end);
    return word;
}

/// Logical lines: a backslash at the end joins the next one.
class Lines {
 public:
    explicit Lines(std::string_view text) : rest_(text) {}

    bool next() {
        if (rest_.empty()) return false;
        line_ = take();
        if (!trimmed(line_).ends_with('\\')) return true;
        joined_.clear();
        while (trimmed(line_).ends_with('\\') && !rest_.empty()) {
            const std::string_view part = trimmed(line_);
            joined_ += part.substr(0, part.size() - 1);
            joined_ += ' ';
            line_ = take();
        }
        joined_ += line_;
        line_ = joined_;
        return true;
    }
    std::string_view line() const { return line_; }
    std::size_t number() const { return number_; }

 private:
    std::string_view take() {
        const std::size_t end = rest_.find('\n');
        const std::string_view line = rest_.substr(0, end);
        rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
        ++number_;
        return line;
    }

    std::string_view rest_, line_;
    std::string joined_;
    std::size_t number_ = 0;
};

/// The file name behind a map statement's options ("-s 1 1 1 -bm 0.5 wood grain.png").
std::string_view file_of_map(std::string_view line) {
    struct Option {
        std::string_view name;
        int max_values;
        bool has_numbers;
    };
    constexpr Option kOptions[] = {
        {"-o", 3, true},       {"-s", 3, true},      {"-t", 3, true},      {"-mm", 2, true},
        {"-bm", 1, true},      {"-boost", 1, true},  {"-texres", 1, true}, {"-blendu", 1, false},
        {"-blendv", 1, false}, {"-clamp", 1, false}, {"-cc", 1, false},    {"-imfchan", 1, false},
        {"-type", 1, false},
    };
    line = trimmed(line);
    while (line.starts_with('-')) {
        std::string_view after = line;
        const std::string_view word = take_word(after);
        const Option* option = std::find_if(std::begin(kOptions), std::end(kOptions),
                                            [&](const Option& o) { return o.name == word; });
        if (option == std::end(kOptions)) break;
        for (int i = 0; i < option->max_values; ++i) {
            std::string_view rest = after;
            const std::string_view value = take_word(rest);
            double number = 0.0;
            if (option->has_numbers && !NumberReader(value).next(number)) break;
            after = rest;
        }
        line = trimmed(after);
    }
    return line;
}

class ObjReader {
 public:
    ObjReader(const std::filesystem::path& path, const Context& context)
        : path_(path),
          name_(path.string()),
          context_(context),
          textures_(path.parent_path(), context) {}

    TexturedMesh read(std::string_view text) {
        Lines lines(text);
        while (lines.next()) {
            line_number_ = lines.number();
            if (line_number_ % kLinesPerPoll == 0) check_cancelled(context_);
            read_line(lines.line());
        }
        Mesh& mesh = mesh_.mesh;
        finish_colors();
        if (!has_uvs_) mesh.uvs.clear();
        if (num_bad_faces_ > 0)
            log(context_, LogLevel::kWarning, "{}: {} faces dropped: fewer than three corners",
                name_, num_bad_faces_);
        return finish_mesh(std::move(mesh_), name_);
    }

 private:
    template <class... Args>
    [[noreturn]] void fail_here(fmt::format_string<Args...> format, Args&&... args) const {
        fail(ErrorCode::kInvalidInput, "{}:{}: {}", name_, line_number_,
             fmt::format(format, std::forward<Args>(args)...));
    }

    void read_line(std::string_view line) {
        const std::string_view word = take_word(line);
        if (word == "v")
            read_vertex(line);
        else if (word == "vt")
            read_uv(line);
        else if (word == "f")
            read_face(line);
        else if (word == "usemtl")
            material_ = material_of(std::string(trimmed(line)));
        else if (word == "mtllib")
            read_libraries(trimmed(line));
    }

    void read_vertex(std::string_view line) {
        std::array<double, 7> values{};
        NumberReader numbers(line);
        std::size_t n = 0;
        while (n < values.size() && numbers.next(values[n])) ++n;
        if (n < 3) fail_here("a vertex needs three numbers: 'v x y z' or 'v x y z r g b'");
        if (mesh_.mesh.positions.size() >= kInvalidIndex - 1)
            fail(ErrorCode::kLimit, "{}: more than 2^32 - 2 vertices", name_);
        mesh_.mesh.positions.push_back({values[0], values[1], values[2]});
        // Four values: x y z w; w is for curves. Seven: colours behind it or an alpha, which differ
        // by nothing that can be seen; x y z r g b a is the usual one.
        if (n < 6) return;
        colors_.resize(mesh_.mesh.positions.size() - 1);
        colors_.push_back({values[3], values[4], values[5]});
    }

    void read_uv(std::string_view line) {
        NumberReader numbers(line);
        double u = 0.0, v = 0.0;
        if (!numbers.next(u)) fail_here("a texture coordinate needs numbers: 'vt u v'");
        numbers.next(v);  // one-dimensional textures leave it out
        // OBJ's origin is the lower left corner, ours the upper left one.
        uvs_.push_back({static_cast<float>(u), static_cast<float>(1.0 - v)});
    }

    /// The element that a one-based or negative (relative to the end) number names.
    std::optional<Index> resolve(std::string_view number, std::size_t size) const {
        double value = 0.0;
        NumberReader reader(number);
        if (!reader.next(value)) return std::nullopt;
        const double index = value < 0.0 ? static_cast<double>(size) + value : value - 1.0;
        if (!(index >= 0.0 && index < static_cast<double>(size)) || index != std::floor(index))
            return std::nullopt;
        return static_cast<Index>(index);
    }

    void read_face(std::string_view line) {
        corners_.clear();
        for (std::string_view word = take_word(line); !word.empty(); word = take_word(line)) {
            if (word.front() == '#') break;
            const std::size_t slash = std::min(word.find('/'), word.size());
            const auto vertex = resolve(word.substr(0, slash), mesh_.mesh.positions.size());
            if (!vertex)
                fail_here("corner '{}' names no vertex; {} were read so far", word,
                          mesh_.mesh.positions.size());
            std::string_view uv = word.substr(std::min(slash + 1, word.size()));
            uv = uv.substr(0, uv.find('/'));
            Corner corner{*vertex, {}};
            if (!uv.empty()) {
                const auto index = resolve(uv, uvs_.size());
                if (!index)
                    fail_here("corner '{}' names no texture coordinate; {} were read so far", word,
                              uvs_.size());
                corner.uv = uvs_[*index];
                has_uvs_ = true;
            }
            corners_.push_back(corner);
        }
        if (corners_.size() < 3) ++num_bad_faces_;
        if (!material_) material_ = material_of("");
        for (std::size_t k = 1; k + 1 < corners_.size(); ++k) {
            const Corner &a = corners_[0], &b = corners_[k], &c = corners_[k + 1];
            mesh_.mesh.triangles.push_back({a.vertex, b.vertex, c.vertex});
            mesh_.mesh.uvs.push_back({a.uv, b.uv, c.uv});
            mesh_.triangle_materials.push_back(*material_);
        }
    }

    /// The number of the material of that name; a plain one if no library has it.
    Index material_of(const std::string& name) {
        const auto next = static_cast<Index>(mesh_.materials.size());
        const auto [entry, is_new] = materials_.try_emplace(name, next);
        if (is_new) {
            mesh_.materials.emplace_back();
            if (!name.empty()) mesh_.materials.back().name = name;
        }
        return entry->second;
    }

    /// Names may hold blanks: the whole line is tried first, then its words.
    void read_libraries(std::string_view line) {
        if (read_library(std::string(line))) return;
        bool has_any = false;
        while (!trimmed(line).empty()) has_any |= read_library(std::string(take_word(line)));
        if (!has_any)
            log(context_, LogLevel::kWarning,
                "{}:{}: material library not found: materials stay plain", name_, line_number_);
    }

    bool read_library(std::string file) {
        std::replace(file.begin(), file.end(), '\\', '/');
        const std::filesystem::path path = path_.parent_path() / file;
        std::error_code error;
        if (!std::filesystem::is_regular_file(path, error)) return false;
        const MappedFile mapped(path);
        Lines lines(as_text(mapped.bytes()));
        Material* material = nullptr;
        while (lines.next()) {
            std::string_view line = lines.line();
            std::string word(take_word(line));
            std::transform(word.begin(), word.end(), word.begin(),
                           [](char c) { return c >= 'A' && c <= 'Z' ? char(c + 32) : c; });
            if (word == "newmtl")
                material = &mesh_.materials[material_of(std::string(trimmed(line)))];
            else if (material != nullptr && word == "map_kd" && !file_of_map(line).empty())
                material->color_image = textures_.load(std::string(file_of_map(line)), mesh_);
            else if (material != nullptr && word == "kd")
                read_color(line, *material);
        }
        for (Material& m : mesh_.materials)
            if (m.color_image >= 0) m.base_color = {1.0, 1.0, 1.0};
        return true;
    }

    static void read_color(std::string_view line, Material& material) {
        NumberReader numbers(line);
        std::array<double, 3> color{};
        if (!numbers.next(color[0])) return;
        // One number means grey.
        if (!numbers.next(color[1]) || !numbers.next(color[2])) color[1] = color[2] = color[0];
        for (std::size_t k = 0; k < 3; ++k)
            material.base_color[k] =
                color[k] > 0.0 ? srgb_to_linear_exact(std::min(color[k], 1.0)) : 0.0;
    }

    void finish_colors() {
        if (colors_.empty()) return;
        colors_.resize(mesh_.mesh.positions.size());
        double max = 0.0;
        for (const Vec3d& c : colors_) max = std::max({max, c.x, c.y, c.z});
        const double scale = max > kUnitColorMax ? 255.0 : 1.0;
        const auto code = [&](double v) {
            const double unit = v > 0.0 ? std::min(v / scale, 1.0) : 0.0;  // NaN becomes 0
            return static_cast<std::uint16_t>(unit * 65535.0 + 0.5);
        };
        for (const Vec3d& c : colors_)
            mesh_.mesh.colors.push_back({code(c.x), code(c.y), code(c.z)});
    }

    struct Corner {
        Index vertex = 0;
        Vec2f uv;
    };

    const std::filesystem::path& path_;
    std::string name_;
    const Context& context_;
    TextureFiles textures_;
    TexturedMesh mesh_;
    std::vector<Vec2f> uvs_;
    std::vector<Vec3d> colors_;
    std::vector<Corner> corners_;
    std::map<std::string, Index> materials_;
    std::optional<Index> material_;
    std::size_t line_number_ = 0;
    std::uint64_t num_bad_faces_ = 0;
    bool has_uvs_ = false;
};

}  // namespace

bool is_obj(std::span<const std::byte> bytes) {
    Lines lines(as_text(bytes.first(std::min<std::size_t>(bytes.size(), 65536))));
    while (lines.next()) {
        std::string_view line = lines.line();
        const std::string_view word = take_word(line);
        if (word.empty() || word.front() == '#') continue;
        constexpr std::string_view kWords[] = {"v",      "vt", "vn", "vp", "f",     "o",
                                               "mtllib", "g",  "s",  "l",  "usemtl"};
        return std::find(std::begin(kWords), std::end(kWords), word) != std::end(kWords);
    }
    return false;
}

TexturedMesh read_obj(std::span<const std::byte> bytes, const std::filesystem::path& path,
                      const Context& context) {
    return ObjReader(path, context).read(as_text(bytes));
}

}  // namespace pointbake
