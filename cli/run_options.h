// Options that belong to the program rather than to a stage: files, limits, talk.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "option_value.h"
#include "pointbake/convert.h"
#include "pointbake/render.h"

namespace pointbake {

namespace cli {
enum class ProgressMode { kBar, kJson, kNone };
}
template <>
struct EnumWords<cli::ProgressMode> {
    static constexpr std::string_view words[] = {"bar", "json", "none"};
};

}  // namespace pointbake

namespace pointbake::cli {

struct MeshOptions {
    std::filesystem::path mesh;
    template <class Field>
    static void describe(Field&& field) {
        field("mesh", &MeshOptions::mesh,
              "bring a mesh (PLY, OBJ, GLB): nothing is reconstructed, only simplified and "
              "textured");
    }
};

/// Cloud whose points a mesh is simplified against.
struct PointsOptions {
    std::filesystem::path points;
    template <class Field>
    static void describe(Field&& field) {
        field("points", &PointsOptions::points,
              "points that the mesh must stay near; else its vertices");
    }
};

struct DemoOptions {
    std::uint64_t points = 200'000;
    template <class Field>
    static void describe(Field&& field) {
        field("points", &DemoOptions::points, "about this many points");
    }
};

struct PictureOptions {
    Vec3d direction = View{}.direction;
    std::optional<Vec3d> up;
    double zoom = View{}.zoom;
    int width = View{}.width, height = View{}.height;
    bool wires = false, transparent = false;
    template <class Field>
    static void describe(Field&& field) {
        field("direction", &PictureOptions::direction, "from the model to the viewer");
        field("up", &PictureOptions::up,
              "what points upwards in the picture (default: y, or z where y is looked along)");
        field("zoom", &PictureOptions::zoom, "1 = all of it fits from every side");
        field("width", &PictureOptions::width, "pixels per view");
        field("height", &PictureOptions::height, "pixels per view");
        field("wires", &PictureOptions::wires,
              "draw each mesh a second time, with its triangles instead of its texture");
        field("transparent", &PictureOptions::transparent, "no background");
    }
};

struct InfoOptions {
    bool json = false;
    template <class Field>
    static void describe(Field&& field) {
        field("json", &InfoOptions::json, "print JSON instead of text");
    }
};

struct StopOptions {
    Stage stop_after = Stage::kWrite;
    template <class Field>
    static void describe(Field&& field) {
        field("stop-after", &StopOptions::stop_after,
              "end after this stage; OUTPUT is then what the stage made (points or mesh)");
    }
};

/// Files beside the output.
struct FileOptions {
    std::filesystem::path work_dir;
    std::filesystem::path write_points;
    std::filesystem::path write_cloud;
    std::filesystem::path report;
    std::filesystem::path debug_maps;
    template <class Field>
    static void describe(Field&& field) {
        field("work-dir", &FileOptions::work_dir,
              "write what each stage made into this folder, as numbered PLY, GLB, PNG, JSON");
        field("write-points", &FileOptions::write_points,
              "write every input row as PLY, with `kept` and `reason`");
        field(
            "write-cloud", &FileOptions::write_cloud,
            "write the points as they were converted, cleaned and denoised, as PLY, with normals");
        field("report", &FileOptions::report,
              "write what was found, done and measured as JSON; - writes to stdout");
        field("debug-maps", &FileOptions::debug_maps,
              "write coverage, error and density of the texels into this folder, as PNG");
    }
};

/// How a run goes; nothing of it changes the output.
struct RunOptions {
    int threads = 0;
    std::optional<ProgressMode> progress;
    template <class Field>
    static void describe(Field&& field) {
        field("threads", &RunOptions::threads,
              "threads to use; 0 = all cores. The output is the same for any number");
        field("progress", &RunOptions::progress,
              "how progress is shown on stderr; by default a bar on a terminal");
    }
};

/// When a conversion is refused, or only talked about.
struct LimitOptions {
    std::optional<ByteSize> max_memory;
    bool strict = false;
    bool dry_run = false;
    template <class Field>
    static void describe(Field&& field) {
        field("max-memory", &LimitOptions::max_memory,
              "refuse at once what is expected to need more, like 12G (exit 5)");
        field("strict", &LimitOptions::strict,
              "a bound that is not met is an error: no model is written, exit 5");
        field("dry-run", &LimitOptions::dry_run,
              "only say what would be done and how much memory it would need");
    }
};

}  // namespace pointbake::cli
