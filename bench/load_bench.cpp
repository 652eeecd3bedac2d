// Reading a million points with colours from each format, in the page cache, in processor time on
// one thread. `read_of_copy`: the time of a copy of the file into fresh pages over that until its
// rows are decoded, in the order of the file; `of_copy`: over that of the whole of load_cloud,
// which merges equal points and puts them in Morton order. `read_MB_per_s`: until the rows are
// decoded.
#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <sys/mman.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>

#include "core/hash.h"
#include "io/order.h"
#include "pointbake/load.h"

namespace pointbake {
namespace {

constexpr std::uint64_t kPoints = 1'000'000;

Vec3d random_position(std::uint64_t i) {
    return {random_unit(1, i), random_unit(2, i), random_unit(3, i)};
}

template <class T>
void append(std::string& bytes, T value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

std::string text_row(std::uint64_t i) {
    const Vec3d p = random_position(i);
    const std::uint64_t c = i % 256;
    return fmt::format("{:.6f} {:.6f} {:.6f} {} {} {}\n", p.x, p.y, p.z, c, c, c);
}

std::string ply_header(std::string_view format) {
    return fmt::format(
        "ply\nformat {} 1.0\nelement vertex {}\nproperty float x\nproperty float y\n"
        "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
        "end_header\n",
        format, kPoints);
}

/// Three floats, and a colour of three bytes, or four for PCD.
void append_binary_row(std::string& bytes, std::uint64_t i, std::size_t color_bytes) {
    append(bytes, vec_cast<float>(random_position(i)));
    bytes.append(color_bytes, static_cast<char>(i % 256));
}

/// Version 1.2, point format 2.
std::string las_file() {
    constexpr std::size_t kHeaderBytes = 227;
    constexpr std::uint16_t kRecordBytes = 26;
    std::string bytes(kHeaderBytes, '\0');
    const auto set = [&](std::size_t at, auto value) {
        std::memcpy(bytes.data() + at, &value, sizeof value);
    };
    std::memcpy(bytes.data(), "LASF", 4);
    bytes[24] = 1, bytes[25] = 2, bytes[104] = 2;
    set(94, static_cast<std::uint16_t>(kHeaderBytes));
    set(96, static_cast<std::uint32_t>(kHeaderBytes));
    set(105, kRecordBytes);
    set(107, static_cast<std::uint32_t>(kPoints));
    for (std::size_t k = 0; k < 3; ++k) set(131 + 8 * k, 1e-6);
    for (std::uint64_t i = 0; i < kPoints; ++i) {
        const Vec3d p = random_position(i);
        for (std::size_t k = 0; k < 3; ++k) append(bytes, static_cast<std::int32_t>(p[k] * 1e6));
        append(bytes, static_cast<std::uint16_t>(i));  // intensity
        bytes.append(6, '\1');
        for (int k = 0; k < 3; ++k) append(bytes, static_cast<std::uint16_t>(i % 256 * 257));
    }
    return bytes;
}

enum Kind { kPly, kLas, kPcd, kPlyText, kXyz };
constexpr const char* kNames[] = {"bench.ply", "bench.las", "bench.pcd", "bench-text.ply",
                                  "bench.xyz"};

std::string bytes_of(Kind kind) {
    std::string bytes;
    if (kind == kLas) return las_file();
    if (kind == kPly) bytes = ply_header("binary_little_endian");
    if (kind == kPlyText) bytes = ply_header("ascii");
    if (kind == kPcd)
        bytes = fmt::format(
            "VERSION 0.7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F U\nCOUNT 1 1 1 1\nWIDTH {0}\n"
            "HEIGHT 1\nPOINTS {0}\nDATA binary\n",
            kPoints);
    for (std::uint64_t i = 0; i < kPoints; ++i) {
        if (kind == kPly || kind == kPcd)
            append_binary_row(bytes, i, kind == kPly ? 3 : 4);
        else
            bytes += text_row(i);
    }
    return bytes;
}

/// Made here, and removed at the end.
class File {
 public:
    explicit File(Kind kind)
        : path_(std::filesystem::temp_directory_path() / kNames[kind]), bytes_(bytes_of(kind)) {
        std::ofstream(path_, std::ios::binary) << bytes_;
    }
    ~File() { std::filesystem::remove(path_); }
    File(const File&) = delete;
    File& operator=(const File&) = delete;

    const std::filesystem::path& path() const { return path_; }
    const std::string& bytes() const { return bytes_; }

 private:
    std::filesystem::path path_;
    std::string bytes_;
};

constexpr int kRuns = 9;

/// Of the processor.
double seconds_since(std::clock_t start) {
    return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

double copy_to_fresh_pages(const std::string& bytes) {
    const std::clock_t start = std::clock();
    void* pages =
        mmap(nullptr, bytes.size(), PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    std::memcpy(pages, bytes.data(), bytes.size());
    benchmark::DoNotOptimize(pages);
    const double seconds = seconds_since(start);
    munmap(pages, bytes.size());
    return seconds;
}

/// The least of several runs each.
struct Seconds {
    double copy = HUGE_VAL, read = HUGE_VAL, whole = HUGE_VAL;
};

Seconds measure(const std::filesystem::path& path, const std::string& bytes, Context context) {
    Seconds least;
    std::clock_t start = 0;
    // Readers tell it when the rows are decoded.
    constexpr double kDecoded = 0.5;
    context.progress = [&](std::string_view, double share) {
        if (share == kDecoded) least.read = std::min(least.read, seconds_since(start));
    };
    for (int run = 0; run < kRuns; ++run) {
        least.copy = std::min(least.copy, copy_to_fresh_pages(bytes));
        start = std::clock();
        benchmark::DoNotOptimize(load_cloud(path, {}, context));
        least.whole = std::min(least.whole, seconds_since(start));
    }
    return least;
}

void load(benchmark::State& state) {
    const auto kind = static_cast<Kind>(state.range(0));
    const File file(kind);
    Context context;
    context.threads = static_cast<int>(state.range(1));
    state.SetLabel(kNames[kind]);
    for (auto _ : state) benchmark::DoNotOptimize(load_cloud(file.path(), {}, context));
    state.SetBytesProcessed(static_cast<std::int64_t>(file.bytes().size()) * state.iterations());
    state.SetItemsProcessed(static_cast<std::int64_t>(kPoints) * state.iterations());
    if (context.threads > 1) return;

    const Seconds least = measure(file.path(), file.bytes(), context);
    state.counters["of_copy"] = least.copy / least.whole;
    state.counters["read_of_copy"] = least.copy / least.read;
    state.counters["read_MB_per_s"] = static_cast<double>(file.bytes().size()) / 1e6 / least.read;
}
BENCHMARK(load)
    ->ArgNames({"kind", "threads"})
    ->ArgsProduct({{kPly, kLas, kPcd, kPlyText, kXyz}, {1, 2}})
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

/// A LAZ file of the test data, for tools/lazrs_time.py to be held against: `read_ms` until its
/// rows are decoded.
void load_laz(benchmark::State& state, const std::filesystem::path& path) {
    Context context;
    context.threads = 1;
    for (auto _ : state) benchmark::DoNotOptimize(load_cloud(path, {}, context));
    state.counters["read_ms"] = 1e3 * measure(path, {}, context).read;
}

const bool has_laz_files = [] {
    const char* const data = std::getenv("POINTBAKE_DATA");
    if (data == nullptr) return false;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(data))
        if (entry.path().extension() == ".laz" && entry.file_size() > 1'000'000)
            benchmark::RegisterBenchmark(
                ("load_laz/" + entry.path().filename().string()).c_str(),
                [path = entry.path()](benchmark::State& state) { load_laz(state, path); })
                ->Unit(benchmark::kMillisecond);
    return true;
}();

void order(benchmark::State& state) {
    PointCloud rows;
    for (std::uint64_t i = 0; i < kPoints; ++i) rows.positions.push_back(random_position(i));
    Context context;
    context.threads = static_cast<int>(state.range(0));
    for (auto _ : state) benchmark::DoNotOptimize(order_cloud(rows, context));
    state.SetItemsProcessed(static_cast<std::int64_t>(kPoints) * state.iterations());
}
BENCHMARK(order)->ArgName("threads")->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace pointbake
