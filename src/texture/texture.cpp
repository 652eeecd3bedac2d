// After [Wicke05], section 4, with one order of events for all patches: measure the error of each
// at every size, choose the sizes, pack, and only then make the texels that are written.
#include "pointbake/texture.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/adjacency.h"
#include "core/message.h"
#include "core/parallel.h"
#include "texture/chart_patches.h"
#include "texture/given_layout.h"
#include "texture/page_painter.h"
#include "texture/sharpen.h"
#include "texture/visibility.h"

namespace pointbake {
namespace {

constexpr std::size_t kGrain = 32;  // triangles per chunk
constexpr int kBisections = 60;     // of the price of a texel

std::vector<Vec3f> map_values(const PointCloud& cloud, MapKind kind, const Footprints& prints) {
    std::vector<Vec3f> values(prints.items.size());
    for (std::size_t i = 0; i < values.size(); ++i) {
        const Index p = prints.items[i].point;
        values[i] = kind == MapKind::kColor ? color_value(cloud.colors[p]) : cloud.normals[p];
    }
    return values;
}

}  // namespace

struct TextureBaker::Impl {
    const Mesh& mesh;
    const PointCloud& cloud;
    TextureOptions options;
    MapKind kind;
    Kernel kernel;
    std::vector<std::array<Index, 3>> neighbors;
    Shell shell;
    Footprints prints;
    SplatScene scene;
    std::vector<Vec3f> raw, linear;
    Sharpened sharpened;
    LevelErrors levels;  // of triangles
    std::optional<ChartPatches> charts;
    std::vector<Vec3f> means;  // per patch

    Impl(const Mesh& m, const PointCloud& c, std::span<const Index> owners, const TextureOptions& o,
         const Context& context)
        : mesh(m),
          cloud(c),
          options(o),
          kind(c.colors.empty() ? MapKind::kNormal : MapKind::kColor),
          kernel(o.paper ? point_shop_kernel() : Kernel{}),
          neighbors(triangle_neighbors(m.triangles)),
          shell(m, o.projection, context),
          prints(project_points(m, c, owners, shell, neighbors, kernel, context)),
          scene{mesh, shell, neighbors, prints, kernel} {
        hide_covered_in_place(prints, cloud, shell, context);
        report_progress(context, "texture", 0.1);
        raw = map_values(cloud, kind, prints);
        std::vector<std::uint64_t> rows(raw.size());
        for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = cloud.rows[prints.items[i].point];
        if (options.paper) {
            sharpened.values = sharpened.splatted = raw;  // eq. (1) is against the points' own
        } else {
            sharpened = sharpen(scene, kind, raw, rows, context);
        }
        if (kind == MapKind::kColor)
            for (const Vec3f& value : sharpened.values) linear.push_back(value_to_linear(value));
        report_progress(context, "texture", 0.3);
        log(context, LogLevel::kDebug, "texture: {} rounds of sharpening", sharpened.rounds);
        if (options.keep_uvs) return;
        log(context, LogLevel::kDebug, "texture: measuring triangles");
        levels = measure_levels(scene, cloud, source().map, options, context);
        prints.widen = std::move(levels.widen);
        report_progress(context, "texture", 0.6);
        if (options.atlas == AtlasKind::kCharts)
            log(context, LogLevel::kDebug, "texture: growing charts"),
                charts.emplace(mesh, neighbors, shell, levels, options.max_side,
                               std::ldexp(1.0, options.mips), options.texture_error, context);
        means = patch_means();
        report_progress(context, "texture", 0.7);
    }
    /// Mean value of the points of each patch; grey where it has none.
    std::vector<Vec3f> patch_means() const {
        std::vector<Vec3f> sums(num_patches());
        std::vector<float> counts(num_patches(), 0.0F);
        for (Index t = 0; t < mesh.triangles.size(); ++t) {
            const Index patch = patch_of(t);
            for (Index i = prints.begin[t]; i < prints.begin[t + 1]; ++i)
                sums[patch] += raw[i], counts[patch] += 1.0F;
        }
        for (std::size_t p = 0; p < sums.size(); ++p)
            sums[p] = counts[p] > 0.0F ? sums[p] / counts[p] : Vec3f{0.5F, 0.5F, 0.5F};
        return sums;
    }
    std::size_t num_patches() const { return charts ? charts->size() : mesh.triangles.size(); }
    std::uint8_t first_within(std::size_t patch, double bound) const {
        return charts ? charts->first_within(static_cast<Index>(patch), bound)
                      : levels.first_within(patch, bound);
    }
    std::uint8_t finest(std::size_t patch) const {
        return charts ? charts->finest(static_cast<Index>(patch))
                      : static_cast<std::uint8_t>(levels.patches[patch].count - 1);
    }
    std::uint8_t cheapest(std::size_t patch, std::uint8_t last, double price) const {
        return charts ? charts->cheapest(static_cast<Index>(patch), last, price)
                      : levels.cheapest(patch, last, price);
    }
    std::int64_t needed(std::size_t patch, std::uint8_t level) const {
        return charts ? static_cast<std::int64_t>(charts->needed(static_cast<Index>(patch), level))
                      : levels.needed(patch, level);
    }
    PatchLayout triangle_layout(Index t, std::uint8_t level) const {
        const TriangleFrame& frame = shell.frame(t);
        return patch_layout(frame, level_density(frame, level));
    }
    NeedSet need(std::size_t patch, std::uint8_t level) const {
        const auto p = static_cast<Index>(patch);
        return charts ? charts->need(p, level) : need_set(triangle_layout(p, level).corners);
    }
    /// What does not depend on sizes.
    void describe(TextureReport& report) const {
        report.sharpening_rounds = sharpened.rounds;
        for (const Footprint& f : prints.items) report.num_hidden_points += f.hidden ? 1 : 0;
    }
    TexturePlan plan(std::span<const std::uint8_t> last, std::int64_t max_needed,
                     const Context& context) const;
    Index patch_of(Index triangle) const {
        return charts ? charts->charts().of_triangle[triangle] : triangle;
    }
    PageLayout page_layout(const TexturePlan& plan, std::span<const PageSize> pages,
                           std::span<const Placement> placements) const;
    double largest_stretch(const PageLayout& layout, const TexturePlan& plan) const;
    CapCount why_capped(Index t, const TexturePlan& plan, double bound) const;
    PaintSource source() const {
        return {
            scene, cloud, {kind, sharpened.values, linear, sharpened.splatted}, raw, options.paper};
    }
};

TextureBaker::TextureBaker(const Mesh& mesh, const PointCloud& cloud, std::span<const Index> owners,
                           const TextureOptions& options, const Context& context) {
    if (owners.size() != cloud.size())
        fail(ErrorCode::kInvalidInput, "{} owners for {} points", owners.size(), cloud.size());
    if (cloud.areas.empty())
        fail(ErrorCode::kInvalidInput, "the texture stage needs the points' areas");
    if (cloud.colors.empty() && cloud.normals.empty()) {
        fail(ErrorCode::kInvalidInput, "the texture stage needs colours or normals");
    }
    report_progress(context, "texture", 0.0);
    impl_ = std::make_unique<Impl>(mesh, cloud, owners, options, context);
}

TextureBaker::~TextureBaker() = default;

TexturePlan TextureBaker::plan(double bound, std::int64_t max_needed,
                               const Context& context) const {
    if (impl_->options.keep_uvs)
        fail(ErrorCode::kInvalidOption, "keep-uvs: sizes of patches are not planned");
    // Where each patch stops if texels cost nothing.
    std::vector<std::uint8_t> last(impl_->num_patches());
    for (std::size_t p = 0; p < last.size(); ++p) last[p] = impl_->first_within(p, bound);
    return impl_->plan(last, max_needed, context);
}

std::optional<TexturePlan> TextureBaker::refined(const TexturePlan& plan, double bound,
                                                 const BakedTexture& baked,
                                                 const Context& context) const {
    constexpr double kFew = 0.02, kMany = 0.2;  // of a patch's triangles
    const Impl& impl = *impl_;
    const int step = impl.charts ? 8 : 1;  // twice the texels
    std::vector<std::size_t> missed(impl.num_patches(), 0), all(impl.num_patches(), 0);
    for (Index t = 0; t < baked.is_missed.size(); ++t) {
        const std::size_t patch = impl.patch_of(t);
        ++all[patch];
        missed[patch] += baked.is_missed[t];
    }
    std::vector<std::uint8_t> raised = plan.raised, last(impl.num_patches());
    raised.resize(impl.num_patches(), 0);
    bool has_changed = false;
    for (std::size_t p = 0; p < last.size(); ++p) {
        const double share = static_cast<double>(missed[p]) / static_cast<double>(all[p]);
        if (share > kFew && plan.levels[p] < impl.finest(p)) {
            raised[p] = static_cast<std::uint8_t>(raised[p] + (share > kMany ? 2 * step : step));
            has_changed = true;
        }
        last[p] = static_cast<std::uint8_t>(
            std::min(impl.first_within(p, bound) + raised[p], int{impl.finest(p)}));
    }
    if (!has_changed) return std::nullopt;
    TexturePlan out = impl.plan(last, std::numeric_limits<std::int64_t>::max(), context);
    out.raised = std::move(raised);
    return out;
}

TexturePlan TextureBaker::Impl::plan(std::span<const std::uint8_t> last, std::int64_t max_needed,
                                     const Context& context) const {
    const std::size_t num_patches = last.size();

    TexturePlan plan;
    const auto choose = [&](double price) {
        std::int64_t total = 0;
        plan.levels.assign(last.begin(), last.end());
        for (std::size_t p = 0; p < num_patches; ++p) {
            if (price > 0.0) plan.levels[p] = cheapest(p, last[p], price);
            total += needed(p, plan.levels[p]);
        }
        return total;
    };
    plan.num_needed = choose(0.0);
    plan.all_at_cap = plan.num_needed <= max_needed;
    if (!plan.all_at_cap) {
        // The price of a texel, in squared error times area: the lowest one that keeps the budget.
        const double area = this->levels.total_area();
        double low = 1e-12 * area, high = 1e12 * area;
        for (int i = 0; i < kBisections; ++i) {
            const double middle = std::sqrt(low * high);
            (choose(middle) > max_needed ? low : high) = middle;
        }
        plan.num_needed = choose(high);
    }
    plan.shapes.resize(num_patches);
    parallel_for(context, num_patches, kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t p = begin; p < end; ++p) {
            plan.shapes[p] = need(p, plan.levels[p]).shape;
            plan.shapes[p].color = means[p];
        }
    });
    return plan;
}

namespace {

// Patch texels to page texels under a placement.
class Pose {
 public:
    Pose(const Placement& place, const NeedSet& need)
        : place_(place),
          offset_{static_cast<double>(need.offset_x), static_cast<double>(need.offset_y)},
          last_{static_cast<double>(need.shape.width() - 1),
                static_cast<double>(need.shape.height() - 1)} {}
    Vec2d place(Vec2d texel) const {
        Vec2d p = texel - offset_;
        if (place_.mirror_x) p.x = last_.x - p.x;
        if (place_.mirror_y) p.y = last_.y - p.y;
        if (place_.transposed) std::swap(p.x, p.y);
        return p + Vec2d{static_cast<double>(place_.x), static_cast<double>(place_.y)};
    }
    PatchLayout place(PatchLayout layout) const {
        for (Vec2d& corner : layout.corners) corner = place(corner);
        layout.origin = vec_cast<float>(place(vec_cast<double>(layout.origin)));
        layout.column_x = turn(layout.column_x);
        layout.column_y = turn(layout.column_y);
        return layout;
    }

 private:
    Vec2f turn(Vec2f d) const {
        if (place_.mirror_x) d.x = -d.x;
        if (place_.mirror_y) d.y = -d.y;
        if (place_.transposed) std::swap(d.x, d.y);
        return d;
    }

    const Placement& place_;
    Vec2d offset_, last_;
};

}  // namespace

PageLayout TextureBaker::Impl::page_layout(const TexturePlan& plan, std::span<const PageSize> pages,
                                           std::span<const Placement> placements) const {
    PageLayout out;
    out.pages.assign(pages.begin(), pages.end());
    out.has_mips = charts.has_value();
    std::vector<Pose> poses;
    for (std::size_t p = 0; p < num_patches(); ++p)
        poses.emplace_back(placements[p], need(p, plan.levels[p]));
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        const Index patch = patch_of(t);
        const std::uint8_t level = plan.levels[patch];
        out.triangle_pages.push_back(placements[patch].page);
        if (!charts) {
            out.triangles.push_back(poses[patch].place(triangle_layout(t, level)));
            continue;
        }
        out.gutters.push_back(charts->gutter(patch, level));
        std::array<Vec2d, 3> corners = charts->corners(t, level);
        for (Vec2d& corner : corners) corner = poses[patch].place(corner);
        const bool has_area = shell.frame(t).area() > 0.0 &&
                              cross(corners[1] - corners[0], corners[2] - corners[0]) != 0.0;
        out.triangles.push_back(has_area ? patch_layout(shell.frame(t), corners)
                                         : PatchLayout{.corners = corners});
    }
    return out;
}

// Of the written layout against the density of each chart.
double TextureBaker::Impl::largest_stretch(const PageLayout& layout,
                                           const TexturePlan& plan) const {
    double worst = 1.0;
    for (Index t = 0; t < layout.triangles.size(); ++t) {
        const PatchLayout& l = layout.triangles[t];
        const double density = charts->density(plan.levels[charts->charts().of_triangle[t]]);
        const Vec2d x = vec_cast<double>(l.column_x) / density,
                    y = vec_cast<double>(l.column_y) / density;
        const double det = std::fabs(cross(x, y));
        if (det == 0.0) continue;
        // Singular values from their squares' sum and their product.
        const double sum = dot(x, x) + dot(y, y);
        const double root = std::sqrt(std::max(sum * sum - 4.0 * det * det, 0.0));
        const double high = std::sqrt(0.5 * (sum + root));
        worst = std::max({worst, high, high / det});
    }
    return worst;
}

CapCount TextureBaker::Impl::why_capped(Index t, const TexturePlan& plan, double bound) const {
    const std::size_t patch = patch_of(t);
    const std::uint8_t chosen = plan.levels[patch], wanted = first_within(patch, bound);
    if (needed(patch, wanted) > needed(patch, chosen)) return &CappedCounts::by_budget;
    const std::uint8_t own = levels.first_within(t, bound);
    if (static_cast<double>(levels.error(t, own)) > bound) return levels.cap(t);
    return charts && charts->is_cut_by_size(static_cast<Index>(patch), bound)
               ? &CappedCounts::by_size
               : &CappedCounts::by_layout;
}

BakedTexture TextureBaker::bake(const TexturePlan& plan, double bound,
                                std::span<const PageSize> pages,
                                std::span<const Placement> placements,
                                const Context& context) const {
    const PaintSource source = impl_->source();
    const PageLayout layout = impl_->page_layout(plan, pages, placements);
    PagePainter painter(source, layout, context);
    log(context, LogLevel::kDebug, "texture: painting");
    painter.find_owners();
    painter.paint(/*for_fit=*/!impl_->options.paper);
    log(context, LogLevel::kDebug, "texture: fitting");
    painter.fit();
    painter.finish(impl_->options.finish_page);
    log(context, LogLevel::kDebug, "texture: measuring pages");
    painter.measure(bound,
                    [&](Index t, TriangleGauge&) { return impl_->why_capped(t, plan, bound); });
    if (impl_->options.debug_maps) painter.draw_debug_maps();
    BakedTexture out = painter.take();
    for (Index t = 0; t < layout.triangles.size(); ++t) {
        const PageSize page = pages[layout.triangle_pages[t]];
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec2d c = layout.triangles[t].corners[k];
            out.model.mesh.uvs[t][k] = {static_cast<float>((c.x + 0.5) / page.width),
                                        static_cast<float>((c.y + 0.5) / page.height)};
        }
    }
    impl_->describe(out.report);
    out.report.num_patches = plan.levels.size();
    if (impl_->charts) out.report.largest_stretch = impl_->largest_stretch(layout, plan);
    return out;
}

GivenBake TextureBaker::bake_given(const GivenLayout& layout, const GivenLimits& limits,
                                   const Context& context) const {
    GivenBake out = paint_given(impl_->source(), layout, limits, impl_->options, context);
    impl_->describe(out.texture.report);
    return out;
}

}  // namespace pointbake
