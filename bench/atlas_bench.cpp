// Packing of log-normal triangle sets, and the fill of what they leave.
#include <benchmark/benchmark.h>

#include <cmath>

#include "core/hash.h"
#include "pointbake/atlas.h"

namespace pointbake {
namespace {

constexpr double kBudgetFill = 0.92;

// Bases of about `base` texels, two thirds within a factor of 1.5.
std::vector<PatchShape> triangles(std::int64_t count, double base) {
    std::vector<PatchShape> out;
    for (std::uint64_t i = 0; i < static_cast<std::uint64_t>(count); ++i) {
        double normal = -6.0;
        for (std::uint64_t k = 0; k < 12; ++k) normal += random_unit(1, 12 * i + k);
        const double b = std::max(1.0, std::round(base * std::exp(0.4 * normal)));
        const double h = std::max(1.0, std::round(b * (0.45 + 0.4 * random_unit(2, i))));
        const double foot = b * (0.15 + 0.7 * random_unit(3, i));
        out.push_back(need_set({Vec2d{0, h}, Vec2d{b, h}, Vec2d{foot, 0}}).shape);
    }
    return out;
}

void BM_pack_into(benchmark::State& state) {
    const auto shapes = triangles(state.range(0), static_cast<double>(state.range(1)));
    double needed = 0.0;
    for (const PatchShape& shape : shapes) needed += static_cast<double>(shape.num_texels());
    const int side = static_cast<int>(std::ceil(std::sqrt(needed / kBudgetFill)));
    const std::vector pages{PageSize{side, side}};
    double fill = 0.0;
    for (auto _ : state) {
        const auto packing = pack_into(shapes, pages);
        fill = packing ? packing->fill() : 0.0;
    }
    state.counters["fill"] = fill;
    state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(BM_pack_into)
    ->Args({10'000, 12})
    ->Args({10'000, 28})
    ->Args({30'000, 12})
    ->Args({100'000, 12})
    ->Unit(benchmark::kMillisecond);

void BM_pack(benchmark::State& state) {
    const auto shapes = triangles(state.range(0), 12.0);
    const AtlasOptions options{.packer = static_cast<Packer>(state.range(1))};
    double fill = 0.0;
    for (auto _ : state) fill = pack(shapes, options).fill();
    state.counters["fill"] = fill;
}
BENCHMARK(BM_pack)->Args({10'000, 0})->Args({10'000, 1})->Unit(benchmark::kMillisecond);

void BM_fill_unowned(benchmark::State& state) {
    const auto side = static_cast<int>(state.range(0));
    Image page{side, side, 3, {}};
    page.pixels.resize(page.num_texels() * 3);
    std::vector<std::uint8_t> owned(page.num_texels());
    for (std::size_t i = 0; i < owned.size(); ++i) owned[i] = hash64(1, i / 7) % 10 != 0 ? 1 : 0;
    for (auto _ : state) fill_unowned_in_place(page, owned);
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(owned.size()));
}
BENCHMARK(BM_fill_unowned)->Arg(1024)->Arg(2048)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace pointbake
