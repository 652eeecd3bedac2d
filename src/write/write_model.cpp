#include <algorithm>
#include <cmath>
#include <string>

#include "core/message.h"
#include "pointbake/write.h"
#include "write/split.h"
#include "write/write_gltf.h"
#include "write/write_obj.h"
#include "write/write_ply.h"

namespace pointbake {
namespace {

std::string lower_extension(const std::filesystem::path& path) {
    std::string extension = path.extension().string();
    // By hand: tolower() depends on the locale.
    for (char& c : extension)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return extension;
}

}  // namespace

WriteReport write_model(const TexturedMesh& model, const std::filesystem::path& path,
                        const WriteOptions& options, const Context& context) {
    if (options.scale && !(std::isfinite(*options.scale) && *options.scale > 0.0))
        fail(ErrorCode::kInvalidOption, "--scale {} is not a positive number", *options.scale);
    const std::string extension = lower_extension(path);
    const bool is_gltf = extension == ".glb" || extension == ".gltf";
    if (!is_gltf && extension != ".obj" && extension != ".ply")
        fail(ErrorCode::kUnsupported,
             "cannot write '{}': its extension is not known: use .glb, .gltf, .obj or .ply",
             path.string());
    check_model(model);
    report_progress(context, "write", 0.0);
    const bool turns = options.up != UpAxis::kAuto && options.up != UpAxis::kY;
    if (!is_gltf && (options.scale.value_or(1.0) != 1.0 || turns))
        log(context, LogLevel::kWarning,
            "--up and --scale are node transforms: {} has none and keeps the input's coordinates",
            extension);
    const WriteReport report = is_gltf               ? write_gltf(model, path, options, context)
                               : extension == ".obj" ? write_obj(model, path, options, context)
                                                     : write_ply(model, path, options, context);
    report_progress(context, "write", 1.0);
    return report;
}

}  // namespace pointbake
