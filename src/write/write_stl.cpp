// 80 bytes that say nothing, the number of triangles, and for each its normal, its corners and two
// bytes of zero, little-endian.
#include "write/write_stl.h"

#include <algorithm>
#include <string>

#include "core/message.h"
#include "core/parallel.h"
#include "write/file_set.h"
#include "write/frame.h"
#include "write/placement.h"
#include "write/split.h"

namespace pointbake {
namespace {

constexpr std::size_t kHeaderBytes = 80;
constexpr std::size_t kTrianglesPerPoll = std::size_t{1} << 16;

std::string header() {
    std::string text = "pointbake " POINTBAKE_VERSION;  // "solid" would begin a text file
    text.resize(kHeaderBytes, ' ');
    return text;
}

Vec3f unit_normal(const std::array<Vec3f, 3>& corners) {
    const Vec3d a = vec_cast<double>(corners[0]);
    const Vec3d n = cross(vec_cast<double>(corners[1]) - a, vec_cast<double>(corners[2]) - a);
    const double size = length(n);
    return size > 0.0 ? vec_cast<float>(n / size) : Vec3f{};
}

}  // namespace

WriteReport write_stl(const TexturedMesh& model, const std::filesystem::path& path,
                      const WriteOptions& options, const Context& context) {
    const Placement32 placement = place_as_floats(model.mesh.positions, model.mesh.triangles);
    std::vector<Triangle> triangles = contract_equal(model.mesh.triangles, placement.positions);
    std::erase_if(triangles,
                  [](const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; });
    if (triangles.empty())
        fail(ErrorCode::kEmpty, "cannot write '{}': the mesh has no triangles", path.string());
    const Vec3d shift = placement.translation;
    if (placement.has_translation())
        log(context, LogLevel::kWarning,
            "STL holds single floats: its coordinates are relative to {} {} {}", shift.x, shift.y,
            shift.z);

    FileSet files;
    AtomicFile& file = files.add(path);
    file.write(header());
    file.write_value(static_cast<std::uint32_t>(triangles.size()));
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        if (i % kTrianglesPerPoll == 0) check_cancelled(context);
        std::array<Vec3f, 3> corners;
        for (std::size_t k = 0; k < 3; ++k) corners[k] = placement.positions[triangles[i][k]];
        file.write_value(unit_normal(corners));
        file.write_value(corners);
        file.write_value(std::uint16_t{0});
    }
    WriteReport report;
    report.frame = settled_frame(model.frame, options);
    report.global_shift = shift;
    report.num_vertices = 3 * triangles.size();
    report.num_draw_calls = 1;
    commit_with_prj(files, path, report, context);
    return report;
}

}  // namespace pointbake
