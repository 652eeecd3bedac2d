// Attributes of a noisy torus: the k-d tree, one query per point, a covariance; and the second half
// over a surface.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <numeric>

#include "core/kdtree.h"
#include "pointbake/attributes.h"
#include "pointbake/sample.h"
#include "support/shapes.h"

namespace pointbake {
namespace {

DenseMesh torus(std::int64_t num_points) {
    const auto nu = static_cast<Index>(std::sqrt(static_cast<double>(num_points) / 2.5));
    DenseMesh surface{shapes::torus_mesh(nu, static_cast<Index>(num_points / nu)), {}};
    surface.vertex_points.resize(surface.mesh.positions.size());
    std::iota(surface.vertex_points.begin(), surface.vertex_points.end(), Index{0});
    return surface;
}

void set_rate(benchmark::State& state, std::size_t num_points) {
    state.counters["points/s"] = benchmark::Counter(static_cast<double>(num_points),
                                                    benchmark::Counter::kIsIterationInvariantRate);
}

void kdtree_build(benchmark::State& state) {
    const DenseMesh surface = torus(state.range(0));
    for (auto _ : state) benchmark::DoNotOptimize(KdTree(surface.mesh.positions));
    set_rate(state, surface.mesh.positions.size());
}
BENCHMARK(kdtree_build)->Arg(10'000)->Arg(200'000)->Unit(benchmark::kMillisecond);

void estimate(benchmark::State& state) {
    PointCloud cloud;
    cloud.positions = torus(state.range(0)).mesh.positions;
    for (auto _ : state) benchmark::DoNotOptimize(estimate_attributes(cloud));
    set_rate(state, cloud.size());
}
BENCHMARK(estimate)->Arg(10'000)->Arg(200'000)->Unit(benchmark::kMillisecond)->UseRealTime();

void refine(benchmark::State& state) {
    const DenseMesh surface = torus(state.range(0));
    PointCloud cloud;
    cloud.positions = surface.mesh.positions;
    cloud = estimate_attributes(std::move(cloud)).cloud;
    for (auto _ : state) benchmark::DoNotOptimize(refine_attributes(cloud, surface));
    set_rate(state, cloud.size());
}
BENCHMARK(refine)->Arg(10'000)->Arg(200'000)->Unit(benchmark::kMillisecond)->UseRealTime();

void spanning_tree(benchmark::State& state) {
    PointCloud cloud;
    cloud.positions = torus(state.range(0)).mesh.positions;
    cloud = estimate_attributes(std::move(cloud)).cloud;
    for (auto _ : state) benchmark::DoNotOptimize(refine_attributes(cloud, {}));
    set_rate(state, cloud.size());
}
BENCHMARK(spanning_tree)->Arg(200'000)->Unit(benchmark::kMillisecond)->UseRealTime();

void sample_mesh(benchmark::State& state) {
    TexturedMesh model;
    model.mesh = shapes::torus_mesh(60, 150);
    const auto mode = static_cast<SampleMode>(state.range(0));
    const SampleOptions options{.mode = mode, .points = 50'000};
    for (auto _ : state) benchmark::DoNotOptimize(sample(model, options));
    set_rate(state, options.points);
}
BENCHMARK(sample_mesh)->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace pointbake
