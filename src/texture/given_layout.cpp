// Each triangle tells the first size that it is content with; the largest of those is taken. A
// texel belongs to the first triangle that covers its centre, else to the first that needs it; then
// what came out is measured on the pages.
#include "texture/given_layout.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "core/message.h"
#include "core/parallel.h"
#include "texture/page_painter.h"

namespace pointbake {
namespace {

constexpr std::size_t kGrain = 32;  // triangles per chunk
constexpr float kRounding = 1e-4F;  // texture coordinates beyond the page by less do not repeat it
constexpr float kFarthest = 16.0F;  // beyond, a layout is a pattern
// Height over the longest side, of a triangle and of its place in the page: less is a line.
constexpr double kLine = 1e-4;
constexpr double kLargestBox = 1 << 25;  // texels around one triangle

using Corners = std::array<Vec2d, 3>;
using Pages = std::vector<PageSize>;

Corners texels_of(const std::array<Vec2f, 3>& uvs, PageSize page) {
    Corners out;
    for (std::size_t k = 0; k < 3; ++k)
        out[k] = {static_cast<double>(uvs[k].x) * page.width - 0.5,
                  static_cast<double>(uvs[k].y) * page.height - 0.5};
    return out;
}

bool has_area(const Corners& c) {
    double longest = 0.0;
    for (std::size_t k = 0; k < 3; ++k) longest = std::max(longest, length(c[(k + 1) % 3] - c[k]));
    return std::fabs(cross(c[1] - c[0], c[2] - c[0])) > kLine * longest * longest;
}

double texels_around(const Corners& c) {
    const auto [left, right] = std::minmax({c[0].x, c[1].x, c[2].x});
    const auto [top, bottom] = std::minmax({c[0].y, c[1].y, c[2].y});
    return (right - left + 3.0) * (bottom - top + 3.0);
}

class GivenPainter {
 public:
    GivenPainter(const PaintSource& source, const GivenLayout& layout, const GivenLimits& limits,
                 const Context& context)
        : source_(source),
          mesh_(source.scene.mesh),
          layout_(layout),
          limits_(limits),
          context_(context) {
        find_repeating();
        find_paintable();
    }

    GivenBake run(const TextureOptions& options) {
        choose_size();
        report_progress(context_, "texture", 0.5);
        out_.pages = limits_.sizes[size_];
        const PageLayout layout = page_layout();
        PagePainter painter(source_, layout, context_);
        painter.find_owners();
        report_progress(context_, "texture", 0.6);
        painter.paint();
        report_progress(context_, "texture", 0.8);
        painter.finish(options.finish_page);
        painter.measure(limits_.bound, [&](Index t, TriangleGauge& gauge) {
            return why_capped(t, gauge, layout.triangles[t]);
        });
        if (options.debug_maps) painter.draw_debug_maps();
        out_.texture = painter.take();
        out_.texture.model.mesh.uvs = mesh_.uvs;
        for (std::size_t i = 0; i < out_.pages.size(); ++i)
            out_.texture.model.materials[i].name = layout_.pages[i].name;
        out_.num_shared_texels = painter.num_shared();
        TextureReport& report = out_.texture.report;
        report.num_patches = mesh_.triangles.size();
        report.payload_texels -= static_cast<double>(out_.num_shared_texels);
        return std::move(out_);
    }

 private:
    void find_repeating() {
        repeats_.assign(layout_.pages.size(), 0);
        for (std::size_t t = 0; t < mesh_.uvs.size(); ++t)
            for (const Vec2f uv : mesh_.uvs[t])
                if (std::min(uv.x, uv.y) < -kRounding || std::max(uv.x, uv.y) > 1.0F + kRounding)
                    repeats_[layout_.triangle_pages[t]] = 1;
    }

    // Triangles with an area in space and in their page.
    void find_paintable() {
        const Pages& largest = limits_.sizes.back();
        is_paintable_.resize(mesh_.triangles.size());
        for (Index t = 0; t < is_paintable_.size(); ++t) {
            is_paintable_[t] =
                has_area(source_.scene.shell.frame(t).corners) && has_area(corners(t, largest));
            out_.num_without_area += is_paintable_[t] == 0 ? 1 : 0;
        }
        if (out_.num_without_area == is_paintable_.size())
            fail(ErrorCode::kInvalidInput,
                 "no triangle covers any area of the layout; without --keep-uvs a new one is made");
    }

    Corners corners(Index t, const Pages& pages) const {
        return texels_of(mesh_.uvs[t], pages[layout_.triangle_pages[t]]);
    }

    // The first size that all triangles with points are content with, as far as memory allows.
    void choose_size() {
        while (num_sizes_ < limits_.sizes.size() && fits(limits_.sizes[num_sizes_])) ++num_sizes_;
        if (num_sizes_ == 0)
            fail(ErrorCode::kLimit,
                 "a triangle repeats its page too often to be painted; without --keep-uvs a new "
                 "layout is made");
        if (num_sizes_ == limits_.sizes.size() && limits_.ends_with_budget)
            cap_of_last_ = &CappedCounts::by_budget;
        while (num_sizes_ > 1 && texels_of_surface(limits_.sizes[num_sizes_ - 2]) >
                                     kTexelsPerPoint * static_cast<double>(source_.cloud.size())) {
            --num_sizes_;
            cap_of_last_ = &CappedCounts::by_count;
        }
        const auto wish = [&](std::size_t begin, std::size_t end) {
            TriangleGauge gauge(source_.scene, source_.cloud, source_.map);
            std::size_t largest = 0;
            for (std::size_t i = begin; i < end; ++i) {
                const Index t = static_cast<Index>(i);
                if (is_paintable_[t] == 0 || source_.scene.prints.of(t).empty()) continue;
                gauge.look_at(t);
                gauge.gather();
                gauge.place_probes();
                gauge.add_border_probes();
                while (largest + 1 < num_sizes_ && !is_content(gauge, t, largest)) ++largest;
            }
            return largest;
        };
        size_ = parallel_reduce(context_, mesh_.triangles.size(), kGrain, std::size_t{0}, wish,
                                [](std::size_t a, std::size_t b) { return std::max(a, b); });
    }

    bool fits(const Pages& pages) const {
        for (Index t = 0; t < mesh_.triangles.size(); ++t)
            if (texels_around(corners(t, pages)) > kLargestBox) return false;
        return true;
    }

    double texels_of_surface(const Pages& pages) const {
        double sum = 0.0;
        for (Index t = 0; t < mesh_.triangles.size(); ++t) {
            const Corners c = corners(t, pages);
            sum += 0.5 * std::fabs(cross(c[1] - c[0], c[2] - c[0]));
        }
        return sum;
    }

    bool is_content(const TriangleGauge& gauge, Index t, std::size_t size) const {
        const PatchLayout layout =
            patch_layout(source_.scene.shell.frame(t), corners(t, limits_.sizes[size]));
        if (layout.pitch() <= gauge.min_pitch()) return true;
        const auto enough = static_cast<double>(kNothingToGain);
        return static_cast<double>(gauge.error(gauge.texels(layout))) <=
               (limits_.bound < HUGE_VAL ? std::max(limits_.bound, enough) : enough);
    }

    // Triangles without an area get no layout.
    PageLayout page_layout() const {
        PageLayout out;
        out.pages = out_.pages;
        out.repeats = repeats_;
        out.has_mips = true;
        out.triangle_pages = layout_.triangle_pages;
        out.triangles.resize(mesh_.triangles.size());
        for (Index t = 0; t < out.triangles.size(); ++t) {
            const Corners c = corners(t, out_.pages);
            out.triangles[t].corners = c;
            if (is_paintable_[t] != 0)
                out.triangles[t] = patch_layout(source_.scene.shell.frame(t), c);
        }
        return out;
    }

    CapCount why_capped(Index t, TriangleGauge& gauge, const PatchLayout& layout) const {
        gauge.look_at(t);
        gauge.gather();
        gauge.place_probes();
        gauge.add_border_probes();
        if (is_paintable_[t] == 0 ||
            static_cast<double>(gauge.error(gauge.texels(layout))) <= limits_.bound)
            return &CappedCounts::by_layout;
        if (layout.pitch() <= gauge.min_pitch() || size_ + 1 < num_sizes_)
            return &CappedCounts::by_spacing;
        return cap_of_last_;
    }

    PaintSource source_;
    const Mesh& mesh_;
    const GivenLayout& layout_;
    const GivenLimits& limits_;
    const Context& context_;
    std::vector<std::uint8_t> repeats_;       // per page: do texture coordinates leave it?
    std::vector<std::uint8_t> is_paintable_;  // per triangle
    CapCount cap_of_last_ = &CappedCounts::by_size;
    std::size_t num_sizes_ = 0, size_ = 0;  // those that can be painted; the one that is
    GivenBake out_;
};

}  // namespace

void validate(const Mesh& mesh, const GivenLayout& layout) {
    if (mesh.uvs.size() != mesh.triangles.size() || mesh.uvs.empty())
        fail(ErrorCode::kInvalidInput,
             "the mesh has no texture coordinates for --keep-uvs to keep");
    if (layout.triangle_pages.size() != mesh.triangles.size())
        fail(ErrorCode::kInvalidInput, "{} triangles, but pages for {} of them",
             mesh.triangles.size(), layout.triangle_pages.size());
    for (std::size_t t = 0; t < mesh.uvs.size(); ++t) {
        if (layout.triangle_pages[t] >= layout.pages.size())
            fail(ErrorCode::kInvalidInput, "triangle {} lies on page {}, but there are {} pages", t,
                 layout.triangle_pages[t], layout.pages.size());
        for (const Vec2f uv : mesh.uvs[t]) {
            if (std::fabs(uv.x) <= kFarthest && std::fabs(uv.y) <= kFarthest) continue;
            fail(ErrorCode::kInvalidInput,
                 "triangle {} has the texture coordinates ({:.4g}, {:.4g}): up to {} is accepted; "
                 "without --keep-uvs a new layout is made",
                 t, uv.x, uv.y, kFarthest);
        }
    }
}

GivenBake paint_given(const PaintSource& source, const GivenLayout& layout,
                      const GivenLimits& limits, const TextureOptions& options,
                      const Context& context) {
    validate(source.scene.mesh, layout);
    return GivenPainter(source, layout, limits, context).run(options);
}

}  // namespace pointbake
