#include "conversion.h"

#include <array>
#include <chrono>

#include "core/memory.h"
#include "core/message.h"
#include "core/parallel.h"
#include "files.h"
#include "memory_watch.h"
#include "summary.h"
#include "work_dir.h"

namespace pointbake::cli {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 5> kModelExtensions = {".glb", ".gltf", ".obj", ".ply",
                                                              ".usdz"};
constexpr std::array<std::string_view, 1> kPointExtensions = {".ply"};

class Stopwatch {
 public:
    double seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

 private:
    using Clock = std::chrono::steady_clock;
    Clock::time_point start_ = Clock::now();
};

bool makes_texture(const Job& job) {
    return job.stop.stop_after > Stage::kSimplify && job.convert.texture.texels != 0;
}

/// Of the texture that the job makes; empty = it makes none.
std::string_view image_extension(const Job& job) {
    if (!makes_texture(job)) return {};
    switch (job.convert.images.format) {
        case ImageFormat::kJpeg:
            return ".jpg";
        case ImageFormat::kWebp:
            return ".webp";
        case ImageFormat::kPng:
            break;
    }
    return ".png";
}

bool writes_points_only(Stage stage) { return stage <= Stage::kAttributes; }

std::vector<std::string> names(const std::vector<fs::path>& paths) {
    std::vector<std::string> names;
    for (const fs::path& path : paths) names.push_back(path.string());
    return names;
}

void check_options(const Job& job) {
    if (job.write.scale && !(*job.write.scale > 0.0))
        fail(ErrorCode::kInvalidOption, "--scale: {} is not positive", *job.write.scale);
    validate(job.convert);
    if (makes_texture(job) && job.convert.images.format == ImageFormat::kPng &&
        job.convert.images.quality != ImageOptions{}.quality)
        fail(ErrorCode::kInvalidOption,
             "--texture-quality is of --texture-format jpeg and webp: PNG loses nothing");
    if (lower_extension(job.output) == ".usdz" && job.convert.images.format == ImageFormat::kWebp)
        fail(ErrorCode::kInvalidOption,
             "--texture-format webp does not go with USDZ, which holds PNG and JPEG");
    if (job.convert.texture.keep_uvs && job.mesh.mesh.empty())
        fail(ErrorCode::kInvalidOption, "--keep-uvs needs a mesh to keep them of: --mesh FILE");
    if (job.output.empty() && job.files.work_dir.empty())
        fail(ErrorCode::kInvalidOption,
             "--stop-after {} needs a place for its result: OUTPUT or --work-dir DIR",
             to_word(job.stop.stop_after));
}

void make_folder(std::string_view option, const fs::path& folder) {
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) fail(ErrorCode::kOutput, "--{} {}: {}", option, folder.string(), error.message());
}

void check_memory(const Job& job, std::uint64_t num_points, bool are_splats) {
    const std::uint64_t needed = predicted_memory(num_points, are_splats);
    if (!job.limits.max_memory || needed <= job.limits.max_memory->bytes) return;
    fail(ErrorCode::kLimit, "{} are expected to need up to {} of memory, more than --max-memory {}",
         counted(num_points, are_splats ? "splat" : "point"), bytes_text(needed),
         bytes_text(job.limits.max_memory->bytes));
}

/// Of splats none are told.
std::vector<std::uint8_t> off_surface(const ConvertResult& result) {
    if (result.splats.size() > 0) return {};
    const SimplifyResult& light = result.light;
    std::vector<std::uint8_t> marks(light.point_triangles.size());
    for (std::size_t i = 0; i < marks.size(); ++i)
        marks[i] = light.point_triangles[i] == kInvalidIndex;
    return marks;
}

bool has_colors(const TexturedMesh& model) {
    return !model.images.empty() || !model.mesh.colors.empty();
}

/// The run in steps; each step is told by its name.
class Run {
 public:
    Run(const Job& job, Console& console, const std::stop_token& stop)
        : job_(job), console_(console), context_(console.context(job.run.threads, stop)) {
        report_.input = fmt::format("{}", fmt::join(names(job.inputs), " "));
        report_.output = job.output.string();
        report_.options = job.result_options;
        report_.last_stage = job.stop.stop_after;
        report_.threads = num_threads(context_);
    }

    void check() {
        check_options(job_);
        check_outputs(job_);
        std::uint64_t promised = 0;
        for (const fs::path& input : job_.inputs) promised += promised_points(input).value_or(0);
        if (promised > 0) check_memory(job_, promised, false);
    }

    ConvertInput load() {
        const Stopwatch watch;
        std::vector<LoadResult> parts;
        for (const fs::path& input : job_.inputs)
            parts.push_back(load_cloud(input, job_.load, context_));
        LoadResult loaded = merge_clouds(std::move(parts), context_);
        report_.load = loaded.report;
        report_.frame = loaded.cloud.frame;
        loaded.cloud.frame = settled_frame(std::move(loaded.cloud.frame), job_.write);
        check_memory(job_, loaded.cloud.size(),
                     goes_around_splats(loaded.cloud, job_.convert) && job_.mesh.mesh.empty());
        ConvertInput input{
            .cloud = std::move(loaded.cloud), .file_mesh = std::move(loaded.mesh), .mesh = {}};
        if (!job_.mesh.mesh.empty()) input.mesh = load_mesh(job_.mesh.mesh, context_);
        if (input.mesh && job_.stop.stop_after == Stage::kSimplify && has_colors(*input.mesh))
            console_.warning(
                fmt::format("the texture and colours of {} are not kept: this is about "
                            "its shape alone",
                            job_.mesh.mesh.string()));
        load_time_ = {Stage::kLoad, watch.seconds(), peak_memory_bytes()};
        return input;
    }

    ConvertResult convert(ConvertInput input) {
        if (report_.last_stage == Stage::kLoad) return loaded_only(std::move(input));
        ConvertOptions options = job_.convert;
        options.stop_after = job_.stop.stop_after;
        options.texture.debug_maps = !job_.files.debug_maps.empty();
        StageObserver observer;
        if (!job_.files.work_dir.empty()) {
            write_text(job_.files.work_dir / "options.json", job_.all_options + "\n");
            observer = work_dir_observer(job_.files.work_dir, job_.write, context_);
        }
        ConvertResult result = naming(report_.input, [&] {
            return pointbake::convert(std::move(input), options, observer, context_);
        });
        report_.convert = result.report;
        for (std::string& line : missed_bounds(report_)) {
            console_.warning(line);
            report_.convert.warnings.push_back(std::move(line));
        }
        report_.convert.times.insert(report_.convert.times.begin(), load_time_);
        if (report_.last_stage >= Stage::kSimplify) add_distributions(report_, result.light);
        return result;
    }

    ConvertResult loaded_only(ConvertInput input) {
        ConvertResult result;
        result.cloud = std::move(input.cloud);
        report_.convert.times = {load_time_};
        return result;
    }

    void write(const ConvertResult& result) {
        const Stopwatch watch;
        report_progress(context_, "write", 0.0);
        if (!job_.output.empty())
            report_.write =
                write_stage(report_.last_stage, result, job_.output, job_.write, context_);
        report_.convert.times.push_back({Stage::kWrite, watch.seconds(), peak_memory_bytes()});
    }

    /// The account of every input row, which is of use when a bound was missed, too.
    void write_rows(const ConvertResult& result) {
        if (!job_.files.write_points.empty())
            write_points(result.splats.size() > 0 ? result.splats : result.cloud,
                         off_surface(result), job_.files.write_points, context_);
    }

    /// With the normals as they were turned last.
    void write_cloud(const ConvertResult& result) {
        if (!job_.files.write_cloud.empty())
            pointbake::write_cloud(result.cloud, job_.files.write_cloud, context_);
    }

    void write_debug_maps(const ConvertResult& result) {
        if (job_.files.debug_maps.empty()) return;
        for (const DebugMap& map : result.debug_maps)
            write_png(map.image, job_.files.debug_maps / (map.name + ".png"), context_);
    }

    void tell() {
        report_.seconds = total_.seconds();
        report_.peak_bytes = peak_memory_bytes();
        const std::string json = report_json(report_);
        if (!job_.files.work_dir.empty()) write_text(job_.files.work_dir / "report.json", json);
        if (job_.files.report == "-")
            print_data(json);
        else if (!job_.files.report.empty())
            write_text(job_.files.report, json);
        for (const std::string& line : summary_lines(report_)) console_.summary(line);
    }

    void tell_plan(const ConvertInput& input) const {
        const std::vector<std::string> lines =
            naming(report_.input, [&] { return plan_lines(job_, input, context_); });
        for (const std::string& line : lines) print_data(line + "\n");
    }

    bool fails_strict() const {
        return job_.limits.strict &&
               (report_.convert.leaves_out_many || !missed_bounds(report_).empty());
    }

 private:
    const Job& job_;
    Console& console_;
    Context context_;
    Stopwatch total_;
    RunReport report_;
    StageTime load_time_{};
};

ConvertResult run_steps(const Job& job, Console& console, const std::stop_token& stop) {
    Run run(job, console, stop);
    run.check();
    ConvertInput input = run.load();
    if (job.limits.dry_run) {
        run.tell_plan(input);
        return {};
    }
    ConvertResult result = run.convert(std::move(input));
    run.write_rows(result);
    run.write_cloud(result);
    run.write_debug_maps(result);
    const bool is_failure = run.fails_strict();
    if (!is_failure) run.write(result);
    run.tell();
    if (is_failure)
        fail(ErrorCode::kLimit,
             "a bound is not met (see the warnings), and with --strict no model is written then");
    return result;
}

}  // namespace

void check_outputs(const Job& job) {
    std::vector<fs::path> taken = job.inputs;
    if (!job.mesh.mesh.empty()) taken.push_back(job.mesh.mesh);
    const auto num_inputs = static_cast<std::ptrdiff_t>(taken.size());
    const auto check = [&](const fs::path& path, std::span<const std::string_view> extensions) {
        if (path.empty() || path == "-") return;
        check_extension(path, extensions);
        if (std::ranges::find(taken.begin() + num_inputs, taken.end(), path) != taken.end())
            fail(ErrorCode::kInvalidOption, "{} is named twice", path.string());
        check_writable(path, taken);
        check_companions(path, taken);
        taken.push_back(path);
    };
    static constexpr std::array<std::string_view, 1> json = {".json"};
    if (writes_points_only(job.stop.stop_after))
        check(job.output, kPointExtensions);
    else if (job.stop.stop_after <= Stage::kSimplify)
        check(job.output, kMeshExtensions);
    else
        check(job.output, kModelExtensions);
    check_no_strangers(job.output, image_extension(job));
    check(job.files.write_cloud, kPointExtensions);
    check(job.files.write_points, kPointExtensions);
    if (!job.files.debug_maps.empty() &&
        std::ranges::find(taken, job.files.debug_maps) != taken.end())
        fail(ErrorCode::kInvalidOption, "{} is named twice", job.files.debug_maps.string());
    check(job.files.report, json);
    if (job.limits.dry_run) return;
    if (!job.files.debug_maps.empty()) {
        make_folder("debug-maps", job.files.debug_maps);
        check_writable(job.files.debug_maps / "coverage-0.png", taken);
    }
    if (job.files.work_dir.empty()) return;
    make_folder("work-dir", job.files.work_dir);
    check_writable(job.files.work_dir / "options.json", taken);
}

ConvertResult run_job(const Job& job, Console& console, const std::stop_token& stop) {
    std::optional<std::uint64_t> most_bytes;
    if (job.limits.max_memory) most_bytes = job.limits.max_memory->bytes;
    const MemoryWatch memory(most_bytes, stop);
    try {
        return run_steps(job, console, memory.token());
    } catch (const Error& error) {
        if (error.code() != ErrorCode::kCancelled || !memory.is_exceeded()) throw;
        fail(ErrorCode::kLimit,
             "{}: more memory is needed than --max-memory {}; fewer points need less (--subsample)",
             fmt::join(names(job.inputs), " "), bytes_text(*most_bytes));
    }
}

}  // namespace pointbake::cli
