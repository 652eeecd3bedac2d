#include <array>
#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "core/message.h"
#include "pointbake/write.h"
#include "write/split.h"
#include "write/write_gltf.h"
#include "write/write_obj.h"
#include "write/write_ply.h"
#include "write/write_stl.h"
#include "write/write_usdz.h"

namespace pointbake {
namespace {

std::string lower_extension(const std::filesystem::path& path) {
    std::string extension = path.extension().string();
    // By hand: tolower() depends on the locale.
    for (char& c : extension)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return extension;
}

using Writer = WriteReport (*)(const TexturedMesh&, const std::filesystem::path&,
                               const WriteOptions&, const Context&);
struct Format {
    std::string_view extension;
    Writer write;
    bool has_transform = false, has_compression = false;
};
constexpr std::array<Format, 6> kFormats = {{{".glb", write_gltf, true, true},
                                             {".gltf", write_gltf, true, true},
                                             {".obj", write_obj},
                                             {".ply", write_ply},
                                             {".stl", write_stl},
                                             {".usdz", write_usdz, true}}};

const Format& format_of(const std::filesystem::path& path) {
    const std::string extension = lower_extension(path);
    std::vector<std::string_view> known;
    for (const Format& format : kFormats) {
        if (format.extension == extension) return format;
        known.push_back(format.extension);
    }
    fail(ErrorCode::kUnsupported, "cannot write '{}': its extension is not known: use one of {}",
         path.string(), fmt::join(known, ", "));
}

}  // namespace

WriteReport write_model(const TexturedMesh& model, const std::filesystem::path& path,
                        const WriteOptions& options, const Context& context) {
    if (options.scale && !(std::isfinite(*options.scale) && *options.scale > 0.0))
        fail(ErrorCode::kInvalidOption, "--scale {} is not a positive number", *options.scale);
    const Format& format = format_of(path);
    check_model(model);
    report_progress(context, "write", 0.0);
    const bool turns = options.up != UpAxis::kAuto && options.up != UpAxis::kY;
    if (!format.has_transform && (options.scale.value_or(1.0) != 1.0 || turns))
        log(context, LogLevel::kWarning,
            "--up and --scale are node transforms: {} has none and keeps the input's coordinates",
            format.extension);
    if (!format.has_compression && options.compress != Compression::kNone)
        log(context, LogLevel::kWarning, "--compress is of GLB and glTF: {} stays as it is",
            format.extension);
    const WriteReport report = format.write(model, path, options, context);
    report_progress(context, "write", 1.0);
    return report;
}

}  // namespace pointbake
