// Based on the USD format as text, UsdPreviewSurface and the USDZ specification (openusd.org). One
// Mesh per material, with split vertices, as in glTF. v runs up there: v_usd = 1 - v.
#include "write/write_usdz.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>

#include "core/color.h"
#include "core/message.h"
#include "core/parallel.h"
#include "write/encode_image.h"
#include "write/file_set.h"
#include "write/frame.h"
#include "write/look.h"
#include "write/placement.h"
#include "write/split.h"
#include "write/stored_zip.h"
#include "write/tangents.h"

namespace pointbake {
namespace {

constexpr std::size_t kElementsPerPoll = std::size_t{1} << 16;

std::string tuple(Vec3f v) { return fmt::format("({}, {}, {})", v.x, v.y, v.z); }

/// The turn about x or z that makes an axis of the input point along +y, in degrees.
std::string rotation_to_y(UpAxis up) {
    if (up == UpAxis::kX) return "(0, 0, 90)";
    if (up == UpAxis::kZ) return "(-90, 0, 0)";
    if (up == UpAxis::kMinusY) return "(180, 0, 0)";
    return {};
}

class UsdzWriter {
 public:
    UsdzWriter(const TexturedMesh& model, const std::filesystem::path& path,
               const WriteOptions& options, const Context& context);

    WriteReport run();

 private:
    template <class... Args>
    void add(fmt::format_string<Args...> format, Args&&... args) {
        fmt::format_to(std::back_inserter(text_), format, std::forward<Args>(args)...);
    }
    /// "name = [value(0), value(1), ...]".
    template <class Value>
    void add_list(std::string_view name, std::size_t count, Value value) {
        add("            {} = [", name);
        for (std::size_t i = 0; i < count; ++i) {
            if (i % kElementsPerPoll == 0) check_cancelled(context_);
            add("{}{}", i == 0 ? "" : ", ", value(i));
        }
        add("]");
    }
    void add_head();
    void add_part(std::size_t number);
    void add_extent(const MeshPart& part);
    void add_material(std::size_t number);
    void add_texture(std::string_view name, int image, std::string_view path, bool is_color);
    void collect_images();
    std::string image_name(int image) const;
    Index vertex(Index corner) const { return triangles_[corner / 3][corner % 3]; }

    const TexturedMesh& model_;
    const std::filesystem::path& path_;
    Frame frame_;
    const Context& context_;
    std::vector<Material> materials_;
    std::vector<Look> looks_;  // one per material
    Placement32 placement_;
    std::vector<Triangle> triangles_;
    std::vector<Vec3f> normals_;
    std::vector<MeshPart> parts_;
    std::vector<int> images_;  // in use
    fmt::memory_buffer text_;
};

UsdzWriter::UsdzWriter(const TexturedMesh& model, const std::filesystem::path& path,
                       const WriteOptions& options, const Context& context)
    : model_(model),
      path_(path),
      frame_(settled_frame(model.frame, options)),
      context_(context),
      materials_(model.materials) {
    if (materials_.empty()) materials_.emplace_back();
    const Mesh& mesh = model.mesh;
    placement_ = place_as_floats(mesh.positions, mesh.triangles);
    triangles_ = contract_equal(mesh.triangles, placement_.positions);
    std::vector<SplitOptions> splits;
    for (const Material& m : materials_) {
        looks_.push_back(look_of(mesh, m, options.shading));
        splits.push_back({.by_uv = looks_.back().has_uvs()});
    }
    normals_ = unit_normals(mesh);
    parts_ = split_by_material(model, triangles_, splits, context);
    if (parts_.empty())
        fail(ErrorCode::kEmpty, "cannot write '{}': the mesh has no triangles", path.string());
    collect_images();
}

void UsdzWriter::collect_images() {
    const auto use = [&](int image) {
        if (std::find(images_.begin(), images_.end(), image) != images_.end()) return;
        if (file_kind(model_.images[static_cast<std::size_t>(image)]).extension == ".webp")
            fail(ErrorCode::kUnsupported,
                 "cannot write '{}': USDZ holds PNG and JPEG, no WebP: --texture-format jpeg",
                 path_.string());
        images_.push_back(image);
    };
    for (const MeshPart& part : parts_) {
        const Look& look = looks_[part.material];
        if (look.has_color_image) use(materials_[part.material].color_image);
        if (look.has_normal_image) use(materials_[part.material].normal_image);
    }
}

std::string UsdzWriter::image_name(int image) const {
    const auto at = std::find(images_.begin(), images_.end(), image) - images_.begin();
    return fmt::format("textures/{}{}", at,
                       file_kind(model_.images[static_cast<std::size_t>(image)]).extension);
}

/// Up to the first mesh. What large coordinates lose is told beside the model instead of moving it:
/// a viewer in a room would put it kilometres away.
void UsdzWriter::add_head() {
    const Vec3d t = placement_.translation;
    add("#usda 1.0\n(\n    defaultPrim = \"model\"\n    metersPerUnit = 1\n    upAxis = \"Y\"\n");
    add("    customLayerData = {{\n        string creator = \"pointbake {}\"\n", POINTBAKE_VERSION);
    if (placement_.has_translation())
        add("        double3 global_shift = ({}, {}, {})\n", t.x, t.y, t.z);
    add("    }}\n)\n\ndef Xform \"model\" (\n    kind = \"component\"\n)\n{{\n");
    const std::string rotation = rotation_to_y(frame_.up);
    const double scale = frame_.metres_per_unit == 0.0 ? 1.0 : frame_.metres_per_unit;
    std::vector<std::string_view> order;
    if (!rotation.empty()) {
        add("    float3 xformOp:rotateXYZ = {}\n", rotation);
        order.push_back("\"xformOp:rotateXYZ\"");
    }
    if (scale != 1.0) {
        add("    float3 xformOp:scale = ({0}, {0}, {0})\n", scale);
        order.push_back("\"xformOp:scale\"");
    }
    if (!order.empty()) add("    uniform token[] xformOpOrder = [{}]\n", fmt::join(order, ", "));
}

void UsdzWriter::add_extent(const MeshPart& part) {
    Vec3f low = placement_.positions[vertex(part.corners.front())], high = low;
    for (const Index corner : part.corners) {
        const Vec3f p = placement_.positions[vertex(corner)];
        for (std::size_t k = 0; k < 3; ++k) {
            low[k] = std::min(low[k], p[k]);
            high[k] = std::max(high[k], p[k]);
        }
    }
    add("            float3[] extent = [{}, {}]\n", tuple(low), tuple(high));
}

void UsdzWriter::add_part(std::size_t number) {
    const MeshPart& part = parts_[number];
    const Look& look = looks_[part.material];
    const std::size_t count = part.corners.size();
    const auto per_vertex = [&] {
        add(" (\n                interpolation = \"vertex\"\n            )\n");
    };
    add("\n    def Mesh \"part_{}\" (\n        prepend apiSchemas = [\"MaterialBindingAPI\"]\n    "
        ")\n"
        "    {{\n",
        number);
    add("            uniform token subdivisionScheme = \"none\"\n");
    if (materials_[part.material].is_double_sided)
        add("            uniform bool doubleSided = 1\n");
    add_extent(part);
    add_list("int[] faceVertexCounts", part.indices.size() / 3, [](std::size_t) { return 3; });
    add("\n");
    add_list("int[] faceVertexIndices", part.indices.size(),
             [&](std::size_t i) { return part.indices[i]; });
    add("\n");
    add_list("point3f[] points", count,
             [&](std::size_t i) { return tuple(placement_.positions[vertex(part.corners[i])]); });
    add("\n");
    add_list("normal3f[] normals", count,
             [&](std::size_t i) { return tuple(normals_[vertex(part.corners[i])]); });
    per_vertex();
    if (look.has_uvs()) {
        add_list("texCoord2f[] primvars:st", count, [&](std::size_t i) {
            const Index corner = part.corners[i];
            const Vec2f uv = model_.mesh.uvs[corner / 3][corner % 3];
            return fmt::format("({}, {})", uv.x,
                               static_cast<float>(1.0 - static_cast<double>(uv.y)));
        });
        per_vertex();
    }
    if (look.has_vertex_colors) {
        add_list("color3f[] primvars:displayColor", count, [&](std::size_t i) {
            return tuple(to_linear(model_.mesh.colors[vertex(part.corners[i])]));
        });
        per_vertex();
    }
    add("            rel material:binding = </model/materials/material_{}>\n    }}\n", number);
}

void UsdzWriter::add_texture(std::string_view name, int image, std::string_view path,
                             bool is_color) {
    const std::string_view wrap =
        model_.images[static_cast<std::size_t>(image)].repeats ? "repeat" : "clamp";
    add("            def Shader \"{}\"\n            {{\n", name);
    add("                uniform token info:id = \"UsdUVTexture\"\n"
        "                asset inputs:file = @{}@\n"
        "                token inputs:sourceColorSpace = \"{}\"\n",
        image_name(image), is_color ? "sRGB" : "raw");
    // A normal map's bytes stand for -1 .. 1.
    if (!is_color)
        add("                float4 inputs:scale = (2, 2, 2, 1)\n"
            "                float4 inputs:bias = (-1, -1, -1, 0)\n");
    add("                token inputs:wrapS = \"{0}\"\n                token inputs:wrapT = "
        "\"{0}\"\n"
        "                float2 inputs:st.connect = <{1}/coordinates.outputs:result>\n"
        "                float3 outputs:rgb\n            }}\n",
        wrap, path);
}

/// Unlit is light that the surface sends out; lit is what it reflects.
void UsdzWriter::add_material(std::size_t number) {
    const Material& m = materials_[parts_[number].material];
    const Look& look = looks_[parts_[number].material];
    const std::string path = fmt::format("/model/materials/material_{}", number);
    const std::string_view light = look.is_lit ? "diffuseColor" : "emissiveColor";
    add("        def Material \"material_{}\"\n        {{\n", number);
    add("            token outputs:surface.connect = <{}/surface.outputs:surface>\n", path);
    add("            def Shader \"surface\"\n            {{\n"
        "                uniform token info:id = \"UsdPreviewSurface\"\n");
    // Without a change of refraction nothing is mirrored, either.
    if (!look.is_lit)
        add("                color3f inputs:diffuseColor = (0, 0, 0)\n"
            "                float inputs:ior = 1\n");
    if (look.has_color_image)
        add("                color3f inputs:{}.connect = <{}/color.outputs:rgb>\n", light, path);
    else if (look.has_vertex_colors)
        add("                color3f inputs:{}.connect = <{}/color.outputs:result>\n", light, path);
    else
        add("                color3f inputs:{} = ({}, {}, {})\n", light, m.base_color[0],
            m.base_color[1], m.base_color[2]);
    if (look.has_normal_image)
        add("                normal3f inputs:normal.connect = <{}/normal.outputs:rgb>\n", path);
    add("                float inputs:metallic = 0\n                float inputs:roughness = 1\n"
        "                token outputs:surface\n            }}\n");
    if (look.has_uvs())
        add("            def Shader \"coordinates\"\n            {{\n"
            "                uniform token info:id = \"UsdPrimvarReader_float2\"\n"
            "                string inputs:varname = \"st\"\n"
            "                float2 outputs:result\n            }}\n");
    if (look.has_color_image) add_texture("color", m.color_image, path, true);
    if (look.has_normal_image) add_texture("normal", m.normal_image, path, false);
    if (look.has_vertex_colors)
        add("            def Shader \"color\"\n            {{\n"
            "                uniform token info:id = \"UsdPrimvarReader_float3\"\n"
            "                string inputs:varname = \"displayColor\"\n"
            "                float3 outputs:result\n            }}\n");
    add("        }}\n");
}

WriteReport UsdzWriter::run() {
    FileSet files;
    AtomicFile& main = files.add(path_);
    WriteReport report;
    add_head();
    for (std::size_t i = 0; i < parts_.size(); ++i) {
        add_part(i);
        report.num_vertices += parts_[i].corners.size();
    }
    add("\n    def Scope \"materials\"\n    {{\n");
    for (std::size_t i = 0; i < parts_.size(); ++i) add_material(i);
    add("    }}\n}}\n");

    StoredZip zip;
    zip.add("model.usda", std::as_bytes(std::span(text_.data(), text_.size())));
    std::vector<std::vector<std::byte>> bytes;
    for (const int image : images_) {
        bytes.push_back(image_file(model_.images[static_cast<std::size_t>(image)], context_));
        zip.add(image_name(image), bytes.back());
        report_progress(
            context_, "write",
            static_cast<double>(bytes.size()) / static_cast<double>(images_.size() + 1));
    }
    zip.write(main);
    report.frame = frame_;
    report.global_shift = placement_.translation;
    report.has_transform = true;
    report.num_draw_calls = parts_.size();
    // No .prj: the shift is not in the file, so the coordinates are not the system's.
    check_cancelled(context_);
    files.commit(report);
    return report;
}

}  // namespace

WriteReport write_usdz(const TexturedMesh& model, const std::filesystem::path& path,
                       const WriteOptions& options, const Context& context) {
    return UsdzWriter(model, path, options, context).run();
}

}  // namespace pointbake
