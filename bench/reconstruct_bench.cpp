// Points per second of the whole stage, and of the triangulation alone.
#include <benchmark/benchmark.h>

#include <cmath>
#include <numbers>

#include "core/hash.h"
#include "pointbake/reconstruct.h"
#include "reconstruct/delaunay.h"

namespace pointbake {
namespace {

// A torus with a wavy tube, randomly sampled: no exact symmetry, as in scans.
PointCloud wavy_torus(std::size_t n) {
    PointCloud cloud;
    for (std::size_t i = 0; i < n; ++i) {
        const double u = 2.0 * std::numbers::pi * random_unit(1, i);
        const double v = 2.0 * std::numbers::pi * random_unit(2, i);
        const double r = 0.4 + 0.05 * std::sin(5.0 * u + 3.0 * v);
        cloud.positions.push_back({(1.0 + r * std::cos(v)) * std::cos(u), r * std::sin(v),
                                   (1.0 + r * std::cos(v)) * std::sin(u)});
    }
    return cloud;
}

void reconstruct_torus(benchmark::State& state, Surface surface) {
    const PointCloud cloud = wavy_torus(static_cast<std::size_t>(state.range(0)));
    for (auto _ : state)
        benchmark::DoNotOptimize(reconstruct(cloud, {.surface = surface}).report.num_triangles);
    state.SetItemsProcessed(state.iterations() * state.range(0));
}

void triangulate_torus(benchmark::State& state) {
    const PointCloud cloud = wavy_torus(static_cast<std::size_t>(state.range(0)));
    for (auto _ : state) benchmark::DoNotOptimize(delaunay(cloud.positions).cells.size());
    state.SetItemsProcessed(state.iterations() * state.range(0));
}

BENCHMARK(triangulate_torus)
    ->RangeMultiplier(10)
    ->Range(10'000, 1'000'000)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(reconstruct_torus, open, Surface::kOpen)
    ->RangeMultiplier(10)
    ->Range(10'000, 1'000'000)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(reconstruct_torus, watertight, Surface::kWatertight)
    ->RangeMultiplier(10)
    ->Range(10'000, 1'000'000)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

}  // namespace
}  // namespace pointbake
