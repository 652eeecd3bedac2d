// Coarse to fine until nothing is left to gain or a cap of [Wicke05], section 4.3, is reached.
#include "texture/level_errors.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"

namespace pointbake {
namespace {

constexpr std::size_t kGrain = 32;  // triangles per chunk
constexpr int kMaxLevels = 40;
constexpr double kFlat =
    1.0;  // one texel is for flat colour: on gradients the triangles would show

bool is_within(int level, float error, double bound) {
    const auto e = static_cast<double>(error);
    return e <= bound && bound < HUGE_VAL && (level > 0 || e <= kFlat);
}

// What forbids a level, if anything.
CapReason cap_of(const TriangleFrame& frame, int level, double min_pitch, std::size_t num_places,
                 int max_patch) {
    if (level <= 1) return CapReason::kNone;
    const double density = level_density(frame, level);
    if (density * min_pitch > 1.0) return CapReason::kSpacing;
    const PatchLayout layout = patch_layout(frame, density);
    if (layout.base + 2 > max_patch) return CapReason::kSize;
    const double surface = 0.5 * layout.base * layout.height;
    const double allowed =
        kTexelsPerPoint * static_cast<double>(std::max<std::size_t>(num_places, 1));
    return surface > allowed && level > 2 ? CapReason::kCount : CapReason::kNone;
}

}  // namespace

double level_density(const TriangleFrame& frame, int level) {
    if (level <= 0 || !(frame.base() > 0.0)) return kOneTexel;
    const int step = level - 1;
    const double odd = (step & 1) ? 1.4142135623730951 : 1.0;
    return std::ldexp(odd, step / 2) / frame.base();
}

std::uint8_t LevelErrors::first_within(std::size_t t, double bound) const {
    std::uint8_t best = 0;
    for (std::uint8_t l = 0; l < patches[t].count; ++l) {
        if (is_within(l, error(t, l), bound)) return l;
        if (error(t, l) < error(t, best)) best = l;
    }
    return best;
}

std::uint8_t LevelErrors::cheapest(std::size_t t, std::uint8_t last, double price) const {
    std::uint8_t best = 0;
    double lowest = HUGE_VAL;
    for (std::uint8_t l = 0; l <= last; ++l) {
        const auto e = static_cast<double>(error(t, l));
        const double cost = patches[t].area * e * e + price * needed(t, l);
        if (cost < lowest) lowest = cost, best = l;
    }
    return best;
}

double LevelErrors::total_area() const {
    double sum = 0.0;
    for (const Patch& p : patches) sum += p.area;
    return sum;
}

LevelErrors measure_levels(const SplatScene& scene, const PointCloud& cloud, const MapValues& map,
                           const TextureOptions& options, const Context& context) {
    const std::size_t num_triangles = scene.mesh.triangles.size();
    // Under a budget texels are weighed against each other, on all levels.
    const double bound = options.texels ? HUGE_VAL : options.texture_error.value_or(HUGE_VAL);
    LevelErrors out;
    out.patches.resize(num_triangles);
    out.widen.resize(num_triangles);
    const std::size_t num_chunks = (num_triangles + kGrain - 1) / kGrain;
    std::vector<std::vector<LevelErrors::Level>> chunks(num_chunks);
    parallel_for(context, num_triangles, kGrain, [&](std::size_t begin, std::size_t end) {
        TriangleGauge gauge(scene, cloud, map, options.paper);
        std::vector<LevelErrors::Level>& levels = chunks[begin / kGrain];
        for (std::size_t t = begin; t < end; ++t) {
            const auto triangle = static_cast<Index>(t);
            const TriangleFrame& frame = scene.shell.frame(triangle);
            gauge.look_at(triangle);
            gauge.gather();
            out.widen[t] = gauge.widen();
            gauge.place_probes();
            gauge.add_border_probes();
            const double min_pitch = gauge.min_pitch();
            // The border of a patch of its own is a seam, with points beside it or not.
            const std::size_t num_places =
                std::max(scene.prints.of(triangle).size(),
                         options.atlas == AtlasKind::kTriangles ? gauge.num_border_places() : 0);
            LevelErrors::Patch& patch = out.patches[t];
            patch.begin = static_cast<Index>(levels.size());
            patch.area = frame.area();
            bool is_enough = false;
            for (int level = 0; level < kMaxLevels; ++level) {
                patch.cap = cap_of(frame, level, min_pitch, num_places, options.max_patch);
                if (patch.cap != CapReason::kNone) break;
                const PatchLayout layout = patch_layout(frame, level_density(frame, level));
                NeedSet need = need_set(layout.corners);
                const auto needed = static_cast<std::int32_t>(need.shape.num_texels());
                ++patch.count;
                const float error = is_enough ? levels.back().error
                                              : gauge.error(gauge.texels(layout, std::move(need)));
                levels.push_back({error, needed});
                if (error <= kNothingToGain) break;
                is_enough = is_within(level, error, bound);
            }
        }
    });
    Index offset = 0;
    for (std::size_t chunk = 0; chunk < num_chunks; ++chunk) {
        for (std::size_t t = chunk * kGrain; t < std::min(num_triangles, (chunk + 1) * kGrain);
             ++t) {
            out.patches[t].begin += offset;
        }
        offset += static_cast<Index>(chunks[chunk].size());
        out.levels.insert(out.levels.end(), chunks[chunk].begin(), chunks[chunk].end());
    }
    return out;
}

CapCount LevelErrors::cap(std::size_t t) const {
    switch (patches[t].cap) {
        case CapReason::kSize:
            return &CappedCounts::by_size;
        case CapReason::kCount:
            return &CappedCounts::by_count;
        default:
            return &CappedCounts::by_spacing;
    }
}

void summarise_distribution(std::vector<float> errors, std::span<const double> areas,
                            TextureReport& report) {
    double area = 0.0;
    for (std::size_t t = 0; t < errors.size(); ++t) {
        const auto e = static_cast<double>(errors[t]);
        area += areas[t];
        report.error_mean += areas[t] * e;
        report.error_rms += areas[t] * e * e;
        report.error_max = std::max(report.error_max, e);
    }
    if (area > 0.0)
        report.error_mean /= area, report.error_rms = std::sqrt(report.error_rms / area);
    if (!errors.empty()) {
        const auto p99 = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() * 99 / 100);
        std::nth_element(errors.begin(), p99, errors.end());
        report.error_p99 = static_cast<double>(*p99);
    }
    report.bound_met = report.capped.total() == 0;
}

}  // namespace pointbake
