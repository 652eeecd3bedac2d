#include "work_dir.h"

#include "core/message.h"

namespace pointbake::cli {
namespace {

namespace fs = std::filesystem;

WriteReport write_mesh_as(const Mesh& mesh, const Frame& frame, const fs::path& path,
                          const WriteOptions& options, const Context& context) {
    TexturedMesh model;
    model.mesh = mesh;
    model.frame = frame;
    return write_model(model, path, options, context);
}

}  // namespace

WriteReport write_stage(Stage stage, const ConvertResult& result, const fs::path& path,
                        const WriteOptions& options, const Context& context) {
    switch (stage) {
        case Stage::kLoad:
        case Stage::kAttributes:
            return write_cloud(result.cloud, path, context);
        case Stage::kReconstruct:
            return write_mesh_as(result.dense.mesh, result.cloud.frame, path, options, context);
        case Stage::kSimplify:
            return write_mesh_as(result.light.mesh, result.cloud.frame, path, options, context);
        case Stage::kTexture:
        case Stage::kWrite:
            break;
    }
    return write_model(result.model, path, options, context);
}

StageObserver work_dir_observer(const fs::path& folder, const WriteOptions& options,
                                const Context& context) {
    // Files beside the run are no part of its progress.
    Context quiet = context;
    quiet.progress = {};
    return [=](Stage stage, const ConvertResult& result) {
        if (stage == Stage::kLoad || stage == Stage::kWrite) return;
        const std::string name = fmt::format("{}-{}", static_cast<int>(stage), to_word(stage));
        const bool is_model = stage == Stage::kTexture;
        write_stage(stage, result, folder / (name + (is_model ? ".glb" : ".ply")), options, quiet);
        if (!is_model) return;
        for (std::size_t i = 0; i < result.model.images.size(); ++i)
            write_png(result.model.images[i], folder / fmt::format("{}-{}.png", name, i), quiet);
    };
}

}  // namespace pointbake::cli
