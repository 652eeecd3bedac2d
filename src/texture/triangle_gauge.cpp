// [Wicke05] eq. (1), normalised: E = sqrt(sum A_s |c_S(p_s) - t(p_s)|^2 / (3 sum A_s)), in 8-bit
// steps, against the splatted function c_S, which sharpening keeps close to the points' own
// colours. E falls to the rounding of 8 bits, so refinement ends; the colours themselves have a
// floor that no number of texels passes.
#include "texture/triangle_gauge.h"

#include <algorithm>
#include <cmath>

namespace pointbake {
namespace {

constexpr int kMaxEdgeProbes = 64;        // per edge
constexpr double kBorderOverReach = 0.7;  // splats gathered beyond the triangle, in splat radii
constexpr float kMostWidened = 4.0F;      // splats where there are none, in their own radii

}  // namespace

void TriangleGauge::look_at(Index triangle) {
    triangle_ = triangle;
    spacing_ = mean_spacing();
    min_pitch_ = find_min_pitch();
    probes_.clear();
    place_border();
}

// Where no splat reaches a place of the border, widened ones tell of it. All that do are gathered,
// so that both sides of an edge see the same, as long as the points are not too far away.
void TriangleGauge::gather(double border) {
    const double grown =
        border + kBorderOverReach * static_cast<double>(scene_.prints.reach[triangle_]);
    const std::vector<float>& known = scene_.prints.widen;
    widen_ = known.empty() ? 1.0F : known[triangle_];
    field_.gather(triangle_, grown, widen_);
    while (known.empty() && widen_ < kMostWidened && !is_border_covered()) {
        widen_ *= 2.0F;
        field_.gather(triangle_, grown, widen_);
    }
}

bool TriangleGauge::is_border_covered() const {
    return std::all_of(border_.begin(), border_.end(),
                       [&](Vec2f place) { return field_.is_covered(place); });
}

void TriangleGauge::place_border() {
    border_.clear();
    if (is_paper_) return;
    const TriangleFrame& frame = scene_.shell.frame(triangle_);
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec2d from = frame.corners[k], along = frame.corners[(k + 1) % 3] - from;
        const double wanted = spacing_ > 0.0 ? length(along) / spacing_ : 1.0;
        const int count = static_cast<int>(std::clamp(wanted, 1.0, double{kMaxEdgeProbes}));
        for (int i = 0; i < count; ++i)
            border_.push_back(vec_cast<float>(from + along * (static_cast<double>(i) / count)));
    }
}

double TriangleGauge::mean_spacing() const {
    const std::span<const Footprint> own = scene_.prints.of(triangle_);
    double area = 0.0;
    for (const Footprint& f : own) area += static_cast<double>(cloud_.areas[f.point]);
    if (area > 0.0) return std::sqrt(area / static_cast<double>(own.size()));
    return static_cast<double>(scene_.prints.reach[triangle_]) /
           (static_cast<double>(scene_.kernel.sigma * scene_.kernel.cut));
}

// [Wicke05] eq. (2) with the 5 % quantile of the spacings instead of their minimum: one close pair
// decides nothing.
double TriangleGauge::find_min_pitch() const {
    std::vector<float> areas;
    for (const Footprint& f : scene_.prints.of(triangle_)) areas.push_back(cloud_.areas[f.point]);
    if (areas.empty()) return spacing_ / (2.0 * std::sqrt(2.0));
    const auto low = areas.begin() + static_cast<std::ptrdiff_t>(areas.size() / 20);
    std::nth_element(areas.begin(), low, areas.end());
    const double d = std::max(std::sqrt(static_cast<double>(*low)), 0.25 * spacing_);
    return d / (2.0 * std::sqrt(2.0));
}

// Coarse texels average what they cover; texels finer than the points have nothing to average.
TexelFilter TriangleGauge::filter(double pitch) const {
    const Kernel& kernel = scene_.kernel;
    const double ratio = spacing_ > 0.0 ? pitch / spacing_ : 1.0;
    const auto rise = [&](double from, double to) {
        return static_cast<float>(std::clamp((ratio - from) / (to - from), 0.0, 1.0));
    };
    const float fade = kernel.fades_low_pass ? rise(0.5, 1.0) : 1.0F;
    return {kernel.low_pass * fade, rise(1.0, 2.0)};
}

PatchTexels TriangleGauge::texels(const PatchLayout& layout) const {
    return texels(layout, need_set(layout.corners));
}

PatchTexels TriangleGauge::texels(const PatchLayout& layout, NeedSet need) const {
    return splat_patch(field_, map_, layout, std::move(need), filter(layout.pitch()));
}

void TriangleGauge::place_probes() {
    const std::span<const Footprint> own = scene_.prints.of(triangle_);
    for (std::size_t k = 0; k < own.size(); ++k) {
        const Footprint& f = own[k];
        if (f.hidden) continue;
        const std::size_t item = scene_.prints.begin[triangle_] + k;
        probes_.push_back(
            {f.center, to_steps(map_.kind, map_.splatted[item]), cloud_.areas[f.point]});
    }
}

double TriangleGauge::probed_area() const {
    double area = 0.0;
    for (const Probe& p : probes_) area += static_cast<double>(p.weight);
    return area;
}

void TriangleGauge::add_border_probes() {
    const double area = scene_.shell.frame(triangle_).area();
    const auto weight = static_cast<float>(std::min(0.5 * spacing_ * spacing_, area / 4.0));
    for (const Vec2f place : border_) {
        const SplatSum s = field_.evaluate(place, map_.values);
        if (s.weight > 0.0F)
            probes_.push_back({place, to_steps(map_.kind, s.sum / s.weight), weight});
    }
}

float TriangleGauge::error(const PatchTexels& texels) const {
    return error([&](Vec2f place) {
        return sample_bilinear(texels, map_.kind, texels.layout.texel_of(place));
    });
}

// --paper: [Wicke05] eq. (1) to the letter, as far as it can be: sum A_s |c_s - t(p_s)|, per area
// of the triangle.
float TriangleGauge::error(const std::function<Vec3f(Vec2f)>& read) const {
    double sum = 0.0, squares = 0.0, weight = 0.0;
    for (const Probe& p : probes_) {
        const auto w = static_cast<double>(p.weight);
        const auto d2 =
            static_cast<double>(squared_length(to_steps(map_.kind, read(p.place)) - p.wanted));
        sum += w * std::sqrt(d2);
        squares += w * d2;
        weight += w;
    }
    if (!is_paper_)
        return weight > 0.0 ? static_cast<float>(std::sqrt(squares / (3.0 * weight))) : 0.0F;
    const double area = scene_.shell.frame(triangle_).area();
    return area > 0.0 ? static_cast<float>(sum / area) : 0.0F;
}

}  // namespace pointbake
