// Writing: images, and a textured mesh of triangle patches.
#include <benchmark/benchmark.h>

#include <cmath>
#include <filesystem>

#include "core/hash.h"
#include "pointbake/write.h"
#include "write/png.h"

namespace pointbake {
namespace {

/// Smooth shades with a little noise, as scanned colours have them.
Image noisy_image(int side) {
    Image image{.width = side, .height = side, .num_channels = 3, .pixels = {}};
    image.pixels.resize(3 * image.num_texels());
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        const std::size_t x = i / 3 % static_cast<std::size_t>(side);
        const std::size_t y = i / 3 / static_cast<std::size_t>(side);
        const double shade = 128.0 + 60.0 * std::sin(static_cast<double>(x) * 0.02) +
                             60.0 * std::sin(static_cast<double>(y) * 0.013);
        image.pixels[i] = static_cast<std::uint8_t>(shade + 6.0 * random_unit(7, i));
    }
    return image;
}

/// A square of 2 * cells^2 triangles, each with texture coordinates of its own.
TexturedMesh patch_mesh(Index cells) {
    TexturedMesh model;
    for (Index y = 0; y <= cells; ++y)
        for (Index x = 0; x <= cells; ++x)
            model.mesh.positions.push_back(
                {static_cast<double>(x), static_cast<double>(y), 0.1 * x});
    for (Index i = 0; i < cells * cells; ++i) {
        const Index a = i / cells * (cells + 1) + i % cells, b = a + cells + 1;
        model.mesh.triangles.push_back({a, a + 1, b + 1});
        model.mesh.triangles.push_back({a, b + 1, b});
    }
    for (std::size_t t = 0; t < model.mesh.triangles.size(); ++t) {
        const auto u = static_cast<float>(random_unit(1, t)),
                   v = static_cast<float>(random_unit(2, t));
        model.mesh.uvs.push_back({Vec2f{u, v}, Vec2f{u, v * 0.5F}, Vec2f{u * 0.5F, v}});
    }
    model.materials.push_back({.color_image = 0});
    model.images.push_back(noisy_image(256));
    return model;
}

void encode_image(benchmark::State& state) {
    const Image image = noisy_image(static_cast<int>(state.range(0)));
    std::size_t num_bytes = 0;
    for (auto _ : state)
        num_bytes = encode_png(image, {.threads = static_cast<int>(state.range(1))}).size();
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(image.num_texels()));
    state.counters["bytes_per_texel"] =
        static_cast<double>(num_bytes) / static_cast<double>(image.num_texels());
}
BENCHMARK(encode_image)
    ->ArgNames({"side", "threads"})
    ->Args({1024, 1})
    ->Args({1024, 2})
    ->Args({4096, 1})
    ->Args({4096, 2})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

void write_file(benchmark::State& state, const char* extension) {
    const TexturedMesh model = patch_mesh(static_cast<Index>(state.range(0)));
    const auto folder = std::filesystem::temp_directory_path() / "pointbake_write_bench";
    std::filesystem::create_directory(folder);
    for (auto _ : state) write_model(model, folder / (std::string("mesh") + extension));
    std::filesystem::remove_all(folder);
    state.SetItemsProcessed(state.iterations() *
                            static_cast<std::int64_t>(model.mesh.triangles.size()));
}
BENCHMARK_CAPTURE(write_file, glb, ".glb")->Arg(70)->Arg(700)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(write_file, obj, ".obj")->Arg(70)->Arg(700)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(write_file, ply, ".ply")->Arg(70)->Arg(700)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace pointbake
