// Based on the Wavefront OBJ and MTL specifications. v runs up there: v_obj = 1 - v.
#include "write/write_obj.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <string>

#include "core/color.h"
#include "core/message.h"
#include "core/parallel.h"
#include "write/encode_image.h"
#include "write/file_set.h"
#include "write/frame.h"
#include "write/split.h"

namespace pointbake {
namespace {

constexpr std::size_t kFlushBytes = std::size_t{1} << 16;

/// Lines of text on their way to a file.
class Lines {
 public:
    Lines(AtomicFile& file, const Context& context) : file_(file), context_(context) {}

    template <class... Args>
    void add(fmt::format_string<Args...> format, Args&&... args) {
        fmt::format_to(std::back_inserter(buffer_), format, std::forward<Args>(args)...);
        if (buffer_.size() >= kFlushBytes) flush();
    }
    void flush() {
        check_cancelled(context_);
        file_.write(std::string_view(buffer_.data(), buffer_.size()));
        buffer_.clear();
    }

 private:
    AtomicFile& file_;
    const Context& context_;
    fmt::memory_buffer buffer_;
};

/// Names that hold no blanks and differ from each other.
std::vector<std::string> unique_names(std::span<const Material> materials) {
    std::vector<std::string> names;
    for (const Material& m : materials) {
        std::string name = m.name.empty() ? "material" : m.name;
        for (char& c : name)
            if (static_cast<unsigned char>(c) <= ' ') c = '_';
        const std::string base = name;
        for (int i = 1; std::find(names.begin(), names.end(), name) != names.end(); ++i)
            name = fmt::format("{}_{}", base, i);
        names.push_back(name);
    }
    return names;
}

class ObjWriter {
 public:
    ObjWriter(const TexturedMesh& model, const std::filesystem::path& path,
              const WriteOptions& options, const Context& context)
        : mesh_(model.mesh),
          model_(model),
          path_(path),
          frame_(settled_frame(model.frame, options)),
          is_lit_(options.shading == Shading::kLit),
          context_(context),
          materials_(model.materials) {
        if (materials_.empty()) materials_.emplace_back();
        names_ = unique_names(materials_);
        has_uvs_ = !mesh_.uvs.empty();
        const std::vector<SplitOptions> splits(materials_.size(), {.by_uv = has_uvs_});
        parts_ = split_by_material(model, mesh_.triangles, splits, context);
        has_normals_ = is_lit_ && !mesh_.normals.empty();
    }

    WriteReport run();

 private:
    void write_vertices(Lines& out) const;
    void write_faces(Lines& out) const;
    void write_materials(FileSet& files, const std::filesystem::path& mtl) const;
    bool has_colors() const;

    const Mesh& mesh_;
    const TexturedMesh& model_;
    const std::filesystem::path& path_;
    Frame frame_;
    bool is_lit_, has_uvs_ = false, has_normals_ = false;
    const Context& context_;
    std::vector<Material> materials_;
    std::vector<std::string> names_;
    std::vector<MeshPart> parts_;
};

/// Vertex colours are written where no texture shows them.
bool ObjWriter::has_colors() const {
    const auto has_image = [](const Material& m) { return m.color_image >= 0; };
    return !mesh_.colors.empty() &&
           !(has_uvs_ && std::any_of(materials_.begin(), materials_.end(), has_image));
}

void ObjWriter::write_vertices(Lines& out) const {
    const bool with_colors = has_colors();
    for (std::size_t v = 0; v < mesh_.positions.size(); ++v) {
        const Vec3d p = mesh_.positions[v];
        // {} prints the shortest text that reads back as the same number.
        out.add("v {} {} {}", p.x, p.y, p.z);
        if (with_colors) {
            const Rgb16 c = mesh_.colors[v];
            out.add(" {:.6} {:.6} {:.6}", c.r / 65535.0, c.g / 65535.0, c.b / 65535.0);
        }
        out.add("\n");
    }
    if (has_normals_)
        for (const Vec3f n : mesh_.normals) out.add("vn {} {} {}\n", n.x, n.y, n.z);
    if (!has_uvs_) return;
    for (const MeshPart& part : parts_) {
        for (const Index corner : part.corners) {
            const Vec2f uv = mesh_.uvs[corner / 3][corner % 3];
            out.add("vt {} {}\n", uv.x, static_cast<float>(1.0 - static_cast<double>(uv.y)));
        }
    }
}

void ObjWriter::write_faces(Lines& out) const {
    std::size_t first_uv = 1;  // indices begin at 1 and go on from part to part
    for (const MeshPart& part : parts_) {
        out.add("usemtl {}\n", names_[part.material]);
        for (std::size_t i = 0; i < part.indices.size(); ++i) {
            const Index corner = part.corners[part.indices[i]];
            const Index v = mesh_.triangles[corner / 3][corner % 3] + 1;
            if (i % 3 == 0) out.add("f");
            out.add(" {}", v);
            if (has_uvs_) out.add("/{}", first_uv + part.indices[i]);
            if (has_normals_) out.add("{}{}", has_uvs_ ? "/" : "//", v);
            if (i % 3 == 2) out.add("\n");
        }
        first_uv += part.corners.size();
    }
}

void ObjWriter::write_materials(FileSet& files, const std::filesystem::path& mtl) const {
    std::vector<int> images;  // in use
    const auto use = [&](int image) {
        if (image >= 0 && has_uvs_ &&
            std::find(images.begin(), images.end(), image) == images.end())
            images.push_back(image);
    };
    for (const MeshPart& part : parts_) {
        use(materials_[part.material].color_image);
        use(materials_[part.material].normal_image);
    }
    const std::vector<std::filesystem::path> paths = image_paths(path_, model_, images);
    const auto name_of = [&](int image) {
        const auto at = std::find(images.begin(), images.end(), image) - images.begin();
        return paths[static_cast<std::size_t>(at)].filename().string();
    };

    Lines out(files.add(mtl), context_);
    for (const MeshPart& part : parts_) {
        const Material& m = materials_[part.material];
        const std::array<double, 3> kd = {linear_to_srgb_exact(m.base_color[0]),
                                          linear_to_srgb_exact(m.base_color[1]),
                                          linear_to_srgb_exact(m.base_color[2])};
        // illum 0 shows the colour as it is, 1 lights it.
        out.add("newmtl {}\nKa 0 0 0\nKd {:.6} {:.6} {:.6}\nKs 0 0 0\nillum {}\n",
                names_[part.material], kd[0], kd[1], kd[2], is_lit_ ? 1 : 0);
        if (has_uvs_ && m.color_image >= 0) out.add("map_Kd {}\n", name_of(m.color_image));
        if (has_uvs_ && m.normal_image >= 0) out.add("norm {}\n", name_of(m.normal_image));
    }
    out.flush();
    for (std::size_t i = 0; i < images.size(); ++i) {
        const Image& image = model_.images[static_cast<std::size_t>(images[i])];
        files.add(paths[i]).write(image_file(image, context_));
        report_progress(context_, "write",
                        static_cast<double>(i + 1) / static_cast<double>(images.size() + 1));
    }
}

WriteReport ObjWriter::run() {
    FileSet files;
    const std::filesystem::path mtl = sibling(path_, ".mtl");
    Lines out(files.add(path_), context_);
    out.add("# pointbake {}\n", POINTBAKE_VERSION);
    if (const std::string text = frame_text(frame_); !text.empty()) out.add("# {}\n", text);
    out.add("mtllib {}\n", mtl.filename().string());
    write_vertices(out);
    write_faces(out);
    out.flush();
    write_materials(files, mtl);
    WriteReport report;
    report.frame = frame_;
    report.num_draw_calls = parts_.size();
    for (const MeshPart& part : parts_) report.num_vertices += part.corners.size();
    commit_with_prj(files, path_, report, context_);
    return report;
}

}  // namespace

WriteReport write_obj(const TexturedMesh& model, const std::filesystem::path& path,
                      const WriteOptions& options, const Context& context) {
    return ObjWriter(model, path, options, context).run();
}

}  // namespace pointbake
