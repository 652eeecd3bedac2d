// Reading PLY: bytes per second by format, points per second of the ordering.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <cstring>
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

/// A million points with colours; removed at the end.
class File {
 public:
    explicit File(bool is_text)
        : path_(std::filesystem::temp_directory_path() /
                (is_text ? "pointbake_bench_text.ply" : "pointbake_bench_binary.ply")) {
        std::string bytes = fmt::format(
            "ply\nformat {} 1.0\nelement vertex {}\nproperty float x\nproperty float y\n"
            "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
            "end_header\n",
            is_text ? "ascii" : "binary_little_endian", kPoints);
        for (std::uint64_t i = 0; i < kPoints; ++i) {
            const Vec3f p = vec_cast<float>(random_position(i));
            const auto c = static_cast<unsigned>(i % 256);
            if (is_text) {
                bytes += fmt::format("{:.6f} {:.6f} {:.6f} {} {} {}\n", p.x, p.y, p.z, c, c, c);
            } else {
                char row[15];
                std::memcpy(row, &p, 12);
                std::memset(row + 12, static_cast<int>(c), 3);
                bytes.append(row, sizeof row);
            }
        }
        size_ = bytes.size();
        std::ofstream(path_, std::ios::binary) << bytes;
    }
    ~File() { std::filesystem::remove(path_); }

    const std::filesystem::path& path() const { return path_; }
    std::size_t size() const { return size_; }

 private:
    std::filesystem::path path_;
    std::size_t size_ = 0;
};

void load(benchmark::State& state) {
    const File file(state.range(0) == 1);
    Context context;
    context.threads = static_cast<int>(state.range(1));
    for (auto _ : state) benchmark::DoNotOptimize(load_cloud(file.path(), {}, context));
    state.SetBytesProcessed(static_cast<std::int64_t>(file.size()) * state.iterations());
    state.SetItemsProcessed(static_cast<std::int64_t>(kPoints) * state.iterations());
}
BENCHMARK(load)
    ->ArgNames({"text", "threads"})
    ->ArgsProduct({{0, 1}, {1, 2}})
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

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
