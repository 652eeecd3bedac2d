// After [Wicke05], section 4, with one order of events for all patches: measure the error of each
// at every size, choose the sizes, pack, and only then make the texels that are written.
#include "pointbake/texture.h"

#include <algorithm>
#include <cmath>

#include "core/adjacency.h"
#include "core/message.h"
#include "core/parallel.h"
#include "texture/given_layout.h"
#include "texture/level_errors.h"
#include "texture/paint_pages.h"
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
    LevelErrors levels;

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
            sharpened.values = raw;
        } else {
            sharpened = sharpen(scene, kind, raw, rows, context);
        }
        if (kind == MapKind::kColor)
            for (const Vec3f& value : sharpened.values) linear.push_back(value_to_linear(value));
        report_progress(context, "texture", 0.3);
        if (options.keep_uvs) return;
        levels = measure_levels(scene, cloud, source().map, options, context);
        report_progress(context, "texture", 0.7);
    }
    /// What does not depend on sizes.
    void describe(TextureReport& report) const {
        report.sharpening_rounds = sharpened.rounds;
        for (const Footprint& f : prints.items) report.num_hidden_points += f.hidden ? 1 : 0;
    }
    PaintSource source() const { return {scene, cloud, {kind, sharpened.values, linear}, raw}; }
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
    impl_ = std::make_unique<Impl>(mesh, cloud, owners, options, context);
}

TextureBaker::~TextureBaker() = default;

TexturePlan TextureBaker::plan(double bound, std::int64_t max_needed) const {
    if (impl_->options.keep_uvs)
        fail(ErrorCode::kInvalidOption, "keep-uvs: sizes of patches are not planned");
    const LevelErrors& levels = impl_->levels;
    const std::size_t num_triangles = impl_->mesh.triangles.size();
    // Where each patch stops if texels cost nothing.
    std::vector<std::uint8_t> last(num_triangles);
    for (std::size_t t = 0; t < num_triangles; ++t) last[t] = levels.first_within(t, bound);

    TexturePlan plan;
    const auto choose = [&](double price) {
        std::int64_t total = 0;
        plan.levels = last;
        for (std::size_t t = 0; t < num_triangles; ++t) {
            if (price > 0.0) plan.levels[t] = levels.cheapest(t, last[t], price);
            total += levels.needed(t, plan.levels[t]);
        }
        return total;
    };
    plan.num_needed = choose(0.0);
    plan.all_at_cap = plan.num_needed <= max_needed;
    if (!plan.all_at_cap) {
        // The price of a texel, in squared error times area: the lowest one that keeps the budget.
        double low = 1e-12 * levels.total_area(), high = 1e12 * levels.total_area();
        for (int i = 0; i < kBisections; ++i) {
            const double middle = std::sqrt(low * high);
            (choose(middle) > max_needed ? low : high) = middle;
        }
        plan.num_needed = choose(high);
    }
    plan.shapes.resize(num_triangles);
    for (std::size_t t = 0; t < num_triangles; ++t) {
        const TriangleFrame& frame = impl_->shell.frame(static_cast<Index>(t));
        plan.shapes[t] =
            need_set(patch_layout(frame, level_density(frame, plan.levels[t])).corners).shape;
    }
    return plan;
}

namespace {

// Patch texel -> page texel under a placement.
struct Pose {
    const Placement& place;
    int width, height;
    int x(int i) const { return place.x + (place.mirror_x ? width - 1 - i : i); }
    int y(int j) const { return place.y + (place.mirror_y ? height - 1 - j : j); }
    Vec2f uv(Vec2d texel, const PageSize& page) const {
        const double px = place.mirror_x ? width - 1 - texel.x : texel.x;
        const double py = place.mirror_y ? height - 1 - texel.y : texel.y;
        return {static_cast<float>((place.x + px + 0.5) / page.width),
                static_cast<float>((place.y + py + 0.5) / page.height)};
    }
};

void copy_to_page(const PatchTexels& patch, const Pose& pose, Image& page,
                  std::vector<std::uint8_t>& owned) {
    for (int row = 0; row < patch.need.shape.height(); ++row) {
        const PatchShape::Span span = patch.need.shape.rows[static_cast<std::size_t>(row)];
        for (int i = span.left; i <= span.right; ++i) {
            const Texel texel = patch.texel(i, row);
            const auto at =
                static_cast<std::size_t>(pose.y(row)) * static_cast<std::size_t>(page.width) +
                static_cast<std::size_t>(pose.x(i));
            std::copy(texel.begin(), texel.end(),
                      page.pixels.begin() + static_cast<std::ptrdiff_t>(3 * at));
            owned[at] = 1;
        }
    }
}

}  // namespace

BakedTexture TextureBaker::bake(const TexturePlan& plan, std::span<const PageSize> pages,
                                std::span<const Placement> placements,
                                const Context& context) const {
    const Impl& impl = *impl_;
    const PaintSource source = impl.source();
    BakedTexture out = empty_pages(source, pages);
    RawErrors raw(source);
    const auto bake_range = [&](std::size_t begin, std::size_t end) {
        TriangleGauge gauge(source.scene, source.cloud, source.map);
        std::uint64_t num_uncovered = 0;
        for (std::size_t t = begin; t < end; ++t) {
            const auto triangle = static_cast<Index>(t);
            const TriangleFrame& frame = impl.shell.frame(triangle);
            gauge.look_at(triangle);
            PatchTexels patch =
                gauge.texels(patch_layout(frame, level_density(frame, plan.levels[t])));
            num_uncovered += patch.num_uncovered;
            raw.measure(triangle, patch);
            const Placement& place = placements[t];
            settle_tangent(source, triangle, place, patch, out.model);
            const Pose pose{place, patch.width(), patch.need.shape.height()};
            copy_to_page(patch, pose, out.model.images[place.page], out.owned[place.page]);
            out.model.triangle_materials[t] = place.page;
            for (std::size_t k = 0; k < 3; ++k) {
                const Vec2d local =
                    patch.layout.corners[k] - Vec2d{static_cast<double>(patch.need.offset_x),
                                                    static_cast<double>(patch.need.offset_y)};
                out.model.mesh.uvs[t][k] = pose.uv(local, pages[place.page]);
            }
        }
        return num_uncovered;
    };
    out.num_uncovered = parallel_reduce(context, impl.mesh.triangles.size(), kGrain,
                                        std::uint64_t{0}, bake_range, std::plus<>());
    raw.summarise(out);
    return out;
}

GivenBake TextureBaker::bake_given(const GivenLayout& layout, const GivenLimits& limits,
                                   const Context& context) const {
    GivenBake out = paint_given(impl_->source(), layout, limits, context);
    impl_->describe(out.report);
    return out;
}

TextureReport TextureBaker::report(const TexturePlan& plan, double bound) const {
    const Impl& impl = *impl_;
    TextureReport out;
    out.bound = bound;
    impl.describe(out);
    out.num_patches = plan.levels.size();
    out.num_needed_texels = static_cast<std::uint64_t>(plan.num_needed);
    summarise_errors(impl.levels, plan.levels, bound, out);
    for (std::size_t t = 0; t < plan.levels.size(); ++t) {
        const TriangleFrame& frame = impl.shell.frame(static_cast<Index>(t));
        const PatchLayout layout = patch_layout(frame, level_density(frame, plan.levels[t]));
        out.payload_texels += 0.5 * layout.base * layout.height;
    }
    return out;
}

}  // namespace pointbake
