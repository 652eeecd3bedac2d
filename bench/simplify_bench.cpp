// Simplification of a wavy sheet, by bound and by budget; closest points on it.
#include <benchmark/benchmark.h>

#include <cmath>

#include "core/bvh.h"
#include "pointbake/simplify.h"

namespace pointbake {
namespace {

// A grid of about n vertices, bent to a wavy sheet.
DenseMesh wavy_sheet(Index n, PointCloud& cloud) {
    DenseMesh dense;
    const Index side = static_cast<Index>(std::sqrt(static_cast<double>(n)));
    for (Index v = 0; v < side; ++v) {
        for (Index u = 0; u < side; ++u) {
            const double x = static_cast<double>(u) / side, y = static_cast<double>(v) / side;
            dense.mesh.positions.push_back(
                {x, y, 0.05 * std::sin(9.0 * x) * std::cos(7.0 * y) + 0.01 * std::sin(40.0 * x)});
            dense.vertex_points.push_back(v * side + u);
        }
    }
    for (Index v = 0; v + 1 < side; ++v) {
        for (Index u = 0; u + 1 < side; ++u) {
            const Index a = v * side + u, b = a + 1, c = a + side, d = c + 1;
            dense.mesh.triangles.push_back({a, b, d});
            dense.mesh.triangles.push_back({a, d, c});
        }
    }
    cloud.positions = dense.mesh.positions;
    return dense;
}

void run(benchmark::State& state, const SimplifyOptions& options) {
    PointCloud cloud;
    const DenseMesh dense = wavy_sheet(static_cast<Index>(state.range(0)), cloud);
    for (auto _ : state) {
        const SimplifyResult result =
            simplify(dense, cloud, options, {.threads = static_cast<int>(state.range(1))});
        state.counters["triangles"] = static_cast<double>(result.mesh.triangles.size());
    }
    state.SetItemsProcessed(state.iterations() * state.range(0));
}

void simplify_by_bound(benchmark::State& state) { run(state, {}); }
void simplify_by_budget(benchmark::State& state) {
    SimplifyOptions options;
    options.triangles = static_cast<Index>(state.range(0) / 20);
    run(state, options);
}
BENCHMARK(simplify_by_bound)
    ->ArgsProduct({{10'000, 100'000, 1'000'000}, {1, 2}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK(simplify_by_budget)
    ->ArgsProduct({{10'000, 100'000, 1'000'000}, {1, 2}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

void closest_points(benchmark::State& state) {
    PointCloud cloud;
    const DenseMesh dense = wavy_sheet(static_cast<Index>(state.range(0)), cloud);
    const TriangleBvh bvh(dense.mesh.positions, dense.mesh.triangles);
    std::size_t i = 0;
    for (auto _ : state) {
        const Vec3d p = cloud.positions[i = (i + 7919) % cloud.size()];
        benchmark::DoNotOptimize(bvh.closest(p + Vec3d{0.0001, 0.0002, 0.01}));
    }
}
BENCHMARK(closest_points)->Arg(100'000);

}  // namespace
}  // namespace pointbake
