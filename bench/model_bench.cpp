// The demo model: surface, paint, points; and the pictures of it.
#include <benchmark/benchmark.h>

#include "pointbake/model.h"
#include "pointbake/render.h"

namespace pointbake {
namespace {

void bench_demo_mesh(benchmark::State& state) {
    for (auto _ : state) benchmark::DoNotOptimize(demo_mesh());
}
BENCHMARK(bench_demo_mesh)->Unit(benchmark::kMillisecond)->UseRealTime();

void bench_paint(benchmark::State& state) {
    constexpr int kPlaces = 100'000;
    for (auto _ : state)
        for (int k = 0; k < kPlaces; ++k) {
            const double t = static_cast<double>(k) / kPlaces;
            benchmark::DoNotOptimize(paint_at({t, 0.2 * t, 0.7}, {0.0, 0.0, 1.0}));
        }
    state.SetItemsProcessed(state.iterations() * kPlaces);
}
BENCHMARK(bench_paint)->Unit(benchmark::kMillisecond);

void bench_demo_cloud(benchmark::State& state) {
    for (auto _ : state)
        benchmark::DoNotOptimize(demo_cloud(static_cast<std::uint64_t>(state.range(0))));
}
BENCHMARK(bench_demo_cloud)
    ->Arg(20'000)
    ->Arg(200'000)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

void bench_render_points(benchmark::State& state) {
    const PointCloud cloud = demo_cloud(static_cast<std::uint64_t>(state.range(0)));
    for (auto _ : state) benchmark::DoNotOptimize(render_points(cloud));
}
BENCHMARK(bench_render_points)->Arg(200'000)->Unit(benchmark::kMillisecond)->UseRealTime();

void bench_render_wires(benchmark::State& state) {
    const Mesh mesh = demo_mesh();
    for (auto _ : state) benchmark::DoNotOptimize(render_mesh(mesh, true));
}
BENCHMARK(bench_render_wires)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace pointbake
