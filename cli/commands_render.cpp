// pointbake render: pictures of clouds and models, side by side and seen by one camera.
#include <algorithm>

#include "command_setup.h"
#include "commands.h"
#include "files.h"
#include "pointbake/render.h"

namespace pointbake::cli {
namespace {

namespace fs = std::filesystem;

constexpr CommandText kRenderText = {
    "pointbake render FILE... [OUT.png] [options]",
    "Draws clouds (as splats) and models (with their texture) side by side, all as the first one\n"
    "is looked at; without OUT.png: FILE-picture.png beside the first."};

/// What one file is drawn from: a cloud, or a model where the file has faces.
struct Subject {
    PointCloud cloud;
    std::optional<TexturedMesh> model;
    const std::vector<Vec3d>& positions() const {
        return model ? model->mesh.positions : cloud.positions;
    }
};

bool is_model(const fs::path& path) {
    const std::string extension = lower_extension(is_packed(path) ? path.stem() : path);
    return extension == ".obj" || extension == ".gltf" || extension == ".glb";
}

/// Upright and in metres, as GLB and glTF are written.
void set_upright(PointCloud& cloud) {
    const UpAxis up = cloud.frame.up;
    const auto turned = [&]<class T>(const Vec3<T>& p) {
        if (up == UpAxis::kZ) return Vec3<T>{p.x, p.z, -p.y};
        return up == UpAxis::kMinusY ? Vec3<T>{p.x, -p.y, -p.z} : p;
    };
    const double unit = cloud.frame.metres_per_unit > 0.0 ? cloud.frame.metres_per_unit : 1.0;
    for (Vec3d& p : cloud.positions) p = turned(p) * unit;
    for (Vec3f& n : cloud.normals) n = turned(n);
    const auto length = static_cast<float>(unit);
    for (TangentAxes& a : cloud.axes) a = {turned(a.u) * length, turned(a.v) * length};
    for (float& r : cloud.radii) r *= length;
    for (float& a : cloud.areas) a *= length * length;
}

/// Models whose coordinates are those of their clouds.
bool keeps_coordinates(const fs::path& path) {
    const std::string extension = lower_extension(is_packed(path) ? path.stem() : path);
    return extension == ".obj" || extension == ".stl";
}

Subject load_subject(const fs::path& path, const LoadOptions& options, bool is_upright,
                     const Context& context) {
    if (is_model(path)) return {.cloud = {}, .model = load_mesh(path, context)};
    LoadResult loaded = load_cloud(path, options, context);
    if (loaded.mesh) return {.cloud = {}, .model = load_mesh(path, context)};
    PointCloud cloud = estimate_attributes(std::move(loaded.cloud), {}, context).cloud;
    if (is_upright) set_upright(cloud);
    return {.cloud = std::move(cloud), .model = {}};
}

/// Looked at from above or below, y cannot point upwards.
Vec3d default_up(Vec3d direction) {
    const Vec3d up = View{}.up;
    return squared_length(cross(up, direction)) > 0.0 ? up : Vec3d{0.0, 0.0, -direction.y};
}

View view_of(const PictureOptions& options, const Subject& first) {
    View view{.direction = options.direction,
              .up = options.up.value_or(default_up(options.direction)),
              .zoom = options.zoom,
              .center = {},
              .width = options.width,
              .height = options.height,
              .is_transparent = options.transparent,
              .box = {}};
    for (const Vec3d& p : first.positions()) view.box.extend(p);
    return view;
}

/// A mesh without colours is shown as clay.
bool has_color(const TexturedMesh& model) {
    return !model.mesh.colors.empty() ||
           std::ranges::any_of(model.materials,
                               [](const Material& m) { return m.color_image >= 0; });
}

/// The last of several names is the picture unless there is such a file that is no picture.
void settle_picture(ParsedLine& line) {
    line.inputs.insert(line.inputs.end(), line.files.begin(), line.files.end());
    if (line.output.empty() && !line.files.empty() && line.inputs.size() > 1) {
        const fs::path& last = line.files.back();
        std::error_code error;
        if (lower_extension(last) == ".png" || !fs::exists(last, error)) {
            line.output = last;
            line.inputs.pop_back();
        }
    }
    if (line.inputs.empty()) fail(ErrorCode::kInvalidOption, "missing FILE; see --help");
    if (line.output.empty()) line.output = beside(line.inputs[0], "-picture.png");
    constexpr std::string_view extension = ".png";
    check_extension(line.output, {&extension, 1});
    check_writable(line.output, line.inputs);
    check_no_texture(line.output, line.inputs);
}

}  // namespace

void run_render(Words words, const std::stop_token& stop) {
    LoadOptions load;
    PictureOptions options;
    RunOptions run;
    OptionTable table;
    table.add(OptionGroup::kReading, true, load);
    table.add(OptionGroup::kOutput, true, options);
    table.add(OptionGroup::kRunning, false, run);
    ParsedLine line;
    if (!read_line(words, kRenderText, table, line)) return;
    settle_picture(line);
    Console console(line.verbosity, run.progress);
    const Context context = console.context(run.threads, stop);
    View view;
    std::vector<Image> pictures;
    const bool is_upright = std::ranges::none_of(line.inputs, keeps_coordinates);
    for (const fs::path& input : line.inputs) {
        const Subject subject = load_subject(input, load, is_upright, context);
        if (pictures.empty()) view = view_of(options, subject);
        if (!subject.model) {
            pictures.push_back(render_points(subject.cloud, view, context));
            continue;
        }
        pictures.push_back(has_color(*subject.model)
                               ? render_textured(*subject.model, view, context)
                               : render_mesh(subject.model->mesh, false, view, context));
        if (options.wires)
            pictures.push_back(render_mesh(subject.model->mesh, true, view, context));
    }
    const Image sheet = contact_sheet(pictures, static_cast<int>(pictures.size()));
    write_png(sheet, line.output, context);
    console.summary(
        fmt::format("wrote {}, {} x {} pixels", line.output.string(), sheet.width, sheet.height));
}

}  // namespace pointbake::cli
