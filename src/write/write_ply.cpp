// Based on [Turk94]; texture coordinates as MeshLab writes and reads them: a list of six per face,
// v up, the image's number in texnumber, the images' names in comments.
#include "write/write_ply.h"

#include <algorithm>
#include <array>

#include "core/message.h"
#include "core/parallel.h"
#include "write/encode_image.h"
#include "write/file_set.h"
#include "write/frame.h"
#include "write/placement.h"
#include "write/ply_output.h"
#include "write/split.h"

namespace pointbake {
namespace {

constexpr std::size_t kRowsPerPoll = std::size_t{1} << 16;

/// Which image each material shows, as numbers of the images that some triangle shows.
struct Pages {
    std::vector<int> images;  // index into the model's, by number
    std::vector<int> of_material;
};

Pages used_pages(const TexturedMesh& model) {
    Pages pages;
    if (model.mesh.uvs.empty()) return pages;
    pages.of_material.assign(model.materials.size(), 0);
    std::vector<char> is_used(model.materials.size(), 0);
    if (!model.materials.empty())
        for (std::size_t t = 0; t < model.mesh.triangles.size(); ++t)
            is_used[material_of(model, t)] = 1;
    for (std::size_t m = 0; m < model.materials.size(); ++m) {
        const int image = model.materials[m].color_image;
        if (image < 0 || !is_used[m]) continue;
        const auto at = std::find(pages.images.begin(), pages.images.end(), image);
        pages.of_material[m] = static_cast<int>(at - pages.images.begin());
        if (at == pages.images.end()) pages.images.push_back(image);
    }
    return pages;
}

class PlyMeshWriter {
 public:
    PlyMeshWriter(const TexturedMesh& model, const std::filesystem::path& path,
                  const WriteOptions& options, const Context& context)
        : model_(model),
          mesh_(model.mesh),
          path_(path),
          frame_(settled_frame(model.frame, options)),
          context_(context),
          pages_(used_pages(model)),
          paths_(image_paths(path, model, pages_.images)),
          as_double_(!are_floats(mesh_.positions)),
          as_16bit_(!are_8bit(mesh_.colors)) {}

    WriteReport run();

 private:
    bool has_pages() const { return !pages_.images.empty(); }
    std::string header() const;
    void write_vertices(AtomicFile& file) const;
    void write_faces(AtomicFile& file) const;

    const TexturedMesh& model_;
    const Mesh& mesh_;
    const std::filesystem::path& path_;
    Frame frame_;
    const Context& context_;
    Pages pages_;
    std::vector<std::filesystem::path> paths_;
    bool as_double_, as_16bit_;
};

std::string PlyMeshWriter::header() const {
    PlyHeader header;
    if (const std::string text = frame_text(frame_); !text.empty()) header.comment(text);
    for (const std::filesystem::path& p : paths_)
        header.comment("TextureFile " + p.filename().string());
    header.element("vertex", mesh_.positions.size());
    header.properties(as_double_ ? "double" : "float", {"x", "y", "z"});
    if (!mesh_.normals.empty()) header.properties("float", {"nx", "ny", "nz"});
    if (!mesh_.colors.empty())
        header.properties(as_16bit_ ? "ushort" : "uchar", {"red", "green", "blue"});
    header.element("face", mesh_.triangles.size());
    header.property("list uchar int", "vertex_indices");
    if (has_pages()) header.property("list uchar float", "texcoord");
    if (pages_.images.size() > 1) header.property("int", "texnumber");
    return header.text();
}

void PlyMeshWriter::write_vertices(AtomicFile& file) const {
    PlyRow row;
    for (std::size_t v = 0; v < mesh_.positions.size(); ++v) {
        if (v % kRowsPerPoll == 0) check_cancelled(context_);
        row.add_position(mesh_.positions[v], as_double_);
        if (!mesh_.normals.empty()) row.add(mesh_.normals[v]);
        if (!mesh_.colors.empty()) row.add_color(mesh_.colors[v], as_16bit_);
        row.write_to(file);
    }
}

void PlyMeshWriter::write_faces(AtomicFile& file) const {
    PlyRow row;
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
        if (t % kRowsPerPoll == 0) check_cancelled(context_);
        row.add(std::uint8_t{3});
        for (const Index v : mesh_.triangles[t]) row.add(static_cast<std::int32_t>(v));
        if (has_pages()) {
            row.add(std::uint8_t{6});
            for (const Vec2f uv : mesh_.uvs[t]) {
                row.add(uv.x);
                row.add(static_cast<float>(1.0 - static_cast<double>(uv.y)));
            }
        }
        if (pages_.images.size() > 1)
            row.add(std::int32_t{pages_.of_material[material_of(model_, t)]});
        row.write_to(file);
    }
}

WriteReport PlyMeshWriter::run() {
    FileSet files;
    AtomicFile& main = files.add(path_);
    main.write(header());
    write_vertices(main);
    write_faces(main);
    for (std::size_t i = 0; i < paths_.size(); ++i) {
        const Image& image = model_.images[static_cast<std::size_t>(pages_.images[i])];
        files.add(paths_[i]).write(image_file(image, context_));
        report_progress(context_, "write",
                        static_cast<double>(i + 1) / static_cast<double>(paths_.size() + 1));
    }
    WriteReport report;
    report.frame = frame_;
    report.num_vertices = mesh_.positions.size();
    report.num_draw_calls = std::max<std::size_t>(1, paths_.size());
    commit_with_prj(files, path_, report, context_);
    return report;
}

}  // namespace

WriteReport write_ply(const TexturedMesh& model, const std::filesystem::path& path,
                      const WriteOptions& options, const Context& context) {
    return PlyMeshWriter(model, path, options, context).run();
}

}  // namespace pointbake
