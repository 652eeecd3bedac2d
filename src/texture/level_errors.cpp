// [Wicke05] eq. (1), normalised: E = sqrt(sum A_s |c_S(p_s) - t(p_s)|^2 / (3 sum A_s)), in 8-bit
// steps, against the splatted function c_S, which sharpening keeps close to the points' own
// colours. E falls to the rounding of 8 bits, so refinement ends; the colours themselves have a
// floor that no number of texels passes.
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
constexpr float kNothingToGain = 0.35F;   // 8-bit rounding alone is 0.29
constexpr double kTexelsPerPoint = 8.0;   // [Wicke05] eq. (2) on a square grid: (d / s)^2 = 8
constexpr int kMaxEdgeProbes = 64;        // per edge
constexpr double kBorderOverReach = 0.7;  // splats gathered beyond the triangle, in splat radii

struct Probe {
    Vec2f place;
    Vec3f wanted;  // steps
    float weight;
};

double mean_spacing(const SplatScene& scene, const PointCloud& cloud, Index triangle) {
    const std::span<const Footprint> own = scene.prints.of(triangle);
    double area = 0.0;
    for (const Footprint& f : own) area += static_cast<double>(cloud.areas[f.point]);
    if (area > 0.0) return std::sqrt(area / static_cast<double>(own.size()));
    return static_cast<double>(scene.prints.reach[triangle]) /
           (static_cast<double>(scene.kernel.sigma * scene.kernel.cut));
}

// Coarse texels average what they cover; texels finer than the points have nothing to average.
float low_pass_variance(const Kernel& kernel, double pitch, double spacing) {
    if (!kernel.fades_low_pass) return kernel.low_pass;
    const double ratio = spacing > 0.0 ? pitch / spacing : 1.0;
    return kernel.low_pass * static_cast<float>(std::clamp(2.0 * ratio - 1.0, 0.0, 1.0));
}

double border_of(const SplatScene& scene, Index triangle) {
    return kBorderOverReach * static_cast<double>(scene.prints.reach[triangle]);
}

PatchTexels patch_at(const LocalField& field, const TriangleFrame& frame, double spacing,
                     MapKind kind, std::span<const Vec3f> values, int level) {
    const PatchLayout layout = patch_layout(frame, level_density(frame, level));
    const double texels = std::max(1.0, static_cast<double>(layout.base) * layout.height);
    const double pitch = std::sqrt(2.0 * frame.area() / texels);
    return splat_patch(field, values, kind, layout,
                       low_pass_variance(field.kernel(), pitch, spacing));
}

void add_probe(std::vector<Probe>& probes, const LocalField& field, MapKind kind,
               std::span<const Vec3f> values, Vec2f place, float weight) {
    const SplatSum s = field.evaluate(place, values);
    if (s.weight > 0.0F) probes.push_back({place, to_steps(kind, s.sum / s.weight), weight});
}

std::vector<Probe> make_probes(const LocalField& field, const SplatScene& scene,
                               const PointCloud& cloud, MapKind kind, std::span<const Vec3f> values,
                               Index triangle) {
    std::vector<Probe> probes;
    const std::span<const Footprint> own = scene.prints.of(triangle);
    for (const Footprint& f : own) {
        if (!f.hidden) add_probe(probes, field, kind, values, f.center, cloud.areas[f.point]);
    }
    // The points say nothing of the border, where the neighbour's patch takes over: look there,
    // too.
    const TriangleFrame& frame = scene.shell.frame(triangle);
    const double spacing = mean_spacing(scene, cloud, triangle);
    const auto weight = static_cast<float>(std::min(0.5 * spacing * spacing, frame.area() / 4.0));
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec2d from = frame.corners[k], along = frame.corners[(k + 1) % 3] - from;
        const int count = std::clamp(static_cast<int>(length(along) / spacing), 1, kMaxEdgeProbes);
        for (int i = 0; i < count; ++i) {
            const Vec2d x = from + along * (static_cast<double>(i) / count);
            add_probe(probes, field, kind, values,
                      {static_cast<float>(x.x), static_cast<float>(x.y)}, weight);
        }
    }
    return probes;
}

// [Wicke05] eq. (1) to the letter, as far as it can be: sum A_s |c_s - t(p_s)|, per area of the
// triangle.
std::vector<Probe> make_paper_probes(const SplatScene& scene, const PointCloud& cloud, MapKind kind,
                                     std::span<const Vec3f> values, Index triangle) {
    std::vector<Probe> probes;
    const std::span<const Footprint> own = scene.prints.of(triangle);
    for (std::size_t k = 0; k < own.size(); ++k) {
        if (own[k].hidden) continue;
        const Vec3f color = to_steps(kind, values[scene.prints.begin[triangle] + k]);
        probes.push_back({own[k].center, color, cloud.areas[own[k].point]});
    }
    return probes;
}

float paper_error(const PatchTexels& patch, MapKind kind, std::span<const Probe> probes,
                  double area) {
    double sum = 0.0;
    for (const Probe& p : probes) {
        const Vec3f d =
            to_steps(kind, sample_bilinear(patch, kind, patch.layout.texel_of(p.place))) - p.wanted;
        sum += static_cast<double>(p.weight) * static_cast<double>(length(d));
    }
    return area > 0.0 ? static_cast<float>(sum / area) : 0.0F;
}

float rms_error(const PatchTexels& patch, MapKind kind, std::span<const Probe> probes) {
    double sum = 0.0, weight = 0.0;
    for (const Probe& p : probes) {
        const Vec3f d =
            to_steps(kind, sample_bilinear(patch, kind, patch.layout.texel_of(p.place))) - p.wanted;
        sum += static_cast<double>(p.weight) * static_cast<double>(squared_length(d));
        weight += static_cast<double>(p.weight);
    }
    return weight > 0.0 ? static_cast<float>(std::sqrt(sum / (3.0 * weight))) : 0.0F;
}

// What forbids a level, if anything.
CapReason cap_of(const TriangleFrame& frame, int level, double min_pitch, std::size_t num_points,
                 int max_patch) {
    if (level <= 1) return CapReason::kNone;
    const double density = level_density(frame, level);
    if (density * min_pitch > 1.0) return CapReason::kSpacing;
    const PatchLayout layout = patch_layout(frame, density);
    if (layout.base + 2 > max_patch) return CapReason::kSize;
    const double surface = 0.5 * layout.base * layout.height;
    const double allowed =
        kTexelsPerPoint * static_cast<double>(std::max<std::size_t>(num_points, 1));
    return surface > allowed && level > 2 ? CapReason::kCount : CapReason::kNone;
}

// [Wicke05] eq. (2) with the 5 % quantile of the spacings instead of their minimum: one close pair
// decides nothing.
double min_pitch_of(const SplatScene& scene, const PointCloud& cloud, Index triangle) {
    std::vector<float> areas;
    for (const Footprint& f : scene.prints.of(triangle)) areas.push_back(cloud.areas[f.point]);
    const double spacing = mean_spacing(scene, cloud, triangle);
    if (areas.empty()) return spacing / (2.0 * std::sqrt(2.0));
    const auto low = areas.begin() + static_cast<std::ptrdiff_t>(areas.size() / 20);
    std::nth_element(areas.begin(), low, areas.end());
    const double d = std::max(std::sqrt(static_cast<double>(*low)), 0.25 * spacing);
    return d / (2.0 * std::sqrt(2.0));
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
        const auto e = static_cast<double>(error(t, l));
        if (e <= bound && bound < HUGE_VAL && (l > 0 || e <= kFlat)) return l;
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

LevelErrors measure_levels(const SplatScene& scene, const PointCloud& cloud, MapKind kind,
                           std::span<const Vec3f> values, const TextureOptions& options,
                           const Context& context) {
    const std::size_t num_triangles = scene.mesh.triangles.size();
    LevelErrors out;
    out.patches.resize(num_triangles);
    const std::size_t num_chunks = (num_triangles + kGrain - 1) / kGrain;
    std::vector<std::vector<LevelErrors::Level>> chunks(num_chunks);
    parallel_for(context, num_triangles, kGrain, [&](std::size_t begin, std::size_t end) {
        LocalField field(scene);
        std::vector<LevelErrors::Level>& levels = chunks[begin / kGrain];
        for (std::size_t t = begin; t < end; ++t) {
            const auto triangle = static_cast<Index>(t);
            const TriangleFrame& frame = scene.shell.frame(triangle);
            const double spacing = mean_spacing(scene, cloud, triangle);
            const double min_pitch = min_pitch_of(scene, cloud, triangle);
            field.gather(triangle, border_of(scene, triangle));
            const std::vector<Probe> probes =
                options.paper ? make_paper_probes(scene, cloud, kind, values, triangle)
                              : make_probes(field, scene, cloud, kind, values, triangle);
            LevelErrors::Patch& patch = out.patches[t];
            patch.begin = static_cast<Index>(levels.size());
            patch.area = frame.area();
            for (int level = 0; level < kMaxLevels; ++level) {
                patch.cap = cap_of(frame, level, min_pitch, scene.prints.of(triangle).size(),
                                   options.max_patch);
                if (patch.cap != CapReason::kNone) break;
                const PatchTexels texels = patch_at(field, frame, spacing, kind, values, level);
                const float error = options.paper ? paper_error(texels, kind, probes, frame.area())
                                                  : rms_error(texels, kind, probes);
                levels.push_back(
                    {error, static_cast<std::int32_t>(texels.need.shape.num_texels())});
                ++patch.count;
                if (error <= kNothingToGain) break;
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

PatchTexels make_patch(LocalField& field, const SplatScene& scene, const PointCloud& cloud,
                       MapKind kind, std::span<const Vec3f> values, Index triangle, int level) {
    field.gather(triangle, border_of(scene, triangle));
    return patch_at(field, scene.shell.frame(triangle), mean_spacing(scene, cloud, triangle), kind,
                    values, level);
}

void summarise_errors(const LevelErrors& levels, std::span<const std::uint8_t> chosen, double bound,
                      TextureReport& report) {
    std::vector<float> errors(chosen.size());
    double area = 0.0;
    for (std::size_t t = 0; t < chosen.size(); ++t) {
        const LevelErrors::Patch& patch = levels.patches[t];
        const auto e = static_cast<double>(levels.error(t, chosen[t]));
        errors[t] = static_cast<float>(e);
        area += patch.area;
        report.error_mean += patch.area * e;
        report.error_rms += patch.area * e * e;
        report.error_max = std::max(report.error_max, e);
        if (e <= bound) continue;
        const std::uint8_t best = levels.first_within(t, bound);
        if (levels.error(t, best) < errors[t] &&
            levels.needed(t, best) > levels.needed(t, chosen[t])) {
            ++report.capped.by_budget;
        } else if (patch.cap == CapReason::kSize) {
            ++report.capped.by_size;
        } else if (patch.cap == CapReason::kCount) {
            ++report.capped.by_count;
        } else {
            ++report.capped.by_spacing;
        }
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
