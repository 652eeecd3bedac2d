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
#include "texture/level_errors.h"

namespace pointbake {
namespace {

constexpr std::size_t kGrain = 32;       // triangles per chunk
constexpr std::size_t kPoll = 1U << 14;  // triangles between two looks at the stop token
constexpr float kRounding = 1e-4F;  // texture coordinates beyond the page by less do not repeat it
constexpr float kFarthest = 16.0F;  // beyond, a layout is a pattern
constexpr double kInside = 1e-6;    // barycentrics: nearer to an edge counts as on it
// Height over the longest side, of a triangle and of its place in the page: less is a line.
constexpr double kLine = 1e-4;
constexpr double kLargestBox = 1 << 25;  // texels around one triangle

using Corners = std::array<Vec2d, 3>;
using Pages = std::vector<PageSize>;
using CapCount = Index CappedCounts::*;

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

// The smallest barycentric coordinate of x.
double depth_inside(const Corners& c, Vec2d x) {
    const double area = cross(c[1] - c[0], c[2] - c[0]);
    return std::min({cross(c[1] - x, c[2] - x) / area, cross(c[2] - x, c[0] - x) / area,
                     cross(c[0] - x, c[1] - x) / area});
}

// Visits the texels of the page that a triangle needs, x and y as its corners have them.
template <class Visit>
void for_each_texel(const Corners& corners, const Image& page, Visit&& visit) {
    const auto has = [&](int x, int y) {
        return page.repeats || (x >= 0 && x < page.width && y >= 0 && y < page.height);
    };
    const NeedSet need = need_set(corners);
    for (int row = 0; row < need.shape.height(); ++row) {
        const PatchShape::Span span = need.shape.rows[static_cast<std::size_t>(row)];
        for (int i = span.left; i <= span.right; ++i) {
            const int x = i + need.offset_x, y = row + need.offset_y;
            if (has(x, y)) visit(x, y);
        }
    }
}

// Who paints a texel: the triangle, and the x and y (as its corners have them) at which it does.
struct TexelOwner {
    Index triangle = kInvalidIndex;
    std::int32_t x = 0, y = 0;
    bool is_inside = false, is_shared = false;
};

// Bilinear, in linear light, as hardware reads a page of colours.
Vec3f read_page(const Image& page, Vec2d texel) {
    const double x0 = std::floor(texel.x), y0 = std::floor(texel.y);
    const auto fx = static_cast<float>(texel.x - x0), fy = static_cast<float>(texel.y - y0);
    const int x = static_cast<int>(x0), y = static_cast<int>(y0);
    const auto at = [&](int i, int j) {
        const std::uint8_t* p = &page.pixels[3 * page.texel(i, j)];
        return decode(MapKind::kColor, {p[0], p[1], p[2]});
    };
    const Vec3f top = at(x, y) * (1.0F - fx) + at(x + 1, y) * fx;
    const Vec3f bottom = at(x, y + 1) * (1.0F - fx) + at(x + 1, y + 1) * fx;
    return linear_to_value(top * (1.0F - fy) + bottom * fy);
}

class Painter {
 public:
    Painter(const PaintSource& source, const GivenLayout& layout, const GivenLimits& limits,
            const Context& context)
        : source_(source),
          mesh_(source.scene.mesh),
          layout_(layout),
          limits_(limits),
          context_(context) {
        find_repeating();
        find_paintable();
    }

    GivenBake run() {
        choose_size();
        report_progress(context_, "texture", 0.5);
        begin();
        find_owners();
        report_progress(context_, "texture", 0.6);
        paint();
        report_progress(context_, "texture", 0.8);
        measure();
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
                gauge.place_probes();
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
        if (pitch(layout) <= gauge.min_pitch()) return true;
        const auto enough = static_cast<double>(kNothingToGain);
        return static_cast<double>(gauge.error(gauge.texels(layout))) <=
               (limits_.bound < HUGE_VAL ? std::max(limits_.bound, enough) : enough);
    }

    static double pitch(const PatchLayout& layout) {
        return 1.0 /
               std::sqrt(std::fabs(static_cast<double>(cross(layout.column_x, layout.column_y))));
    }

    void begin() {
        out_.pages = limits_.sizes[size_];
        out_.texture = empty_pages(source_, out_.pages);
        TexturedMesh& model = out_.texture.model;
        model.mesh.uvs = mesh_.uvs;
        model.triangle_materials = layout_.triangle_pages;
        for (std::size_t i = 0; i < out_.pages.size(); ++i) {
            model.materials[i].name = layout_.pages[i].name;
            model.images[i].repeats = repeats_[i] != 0;
        }
    }

    void find_owners() {
        for (const PageSize page : out_.pages)
            owners_.emplace_back(static_cast<std::size_t>(num_texels(page)));
        for (Index t = 0; t < mesh_.triangles.size(); ++t) {
            if (t % kPoll == 0) check_cancelled(context_);
            if (is_paintable_[t] == 0) continue;
            const Corners c = corners(t, out_.pages);
            const Index page = layout_.triangle_pages[t];
            const Image& image = out_.texture.model.images[page];
            for_each_texel(c, image, [&](int x, int y) {
                const double depth =
                    depth_inside(c, {static_cast<double>(x), static_cast<double>(y)});
                TexelOwner& owner = owners_[page][image.texel(x, y)];
                if (owner.is_inside) {
                    owner.is_shared = owner.is_shared || depth > kInside;
                } else if (depth >= -kInside || owner.triangle == kInvalidIndex) {
                    owner = {t, x, y, depth >= -kInside, false};
                }
            });
        }
    }

    void paint() {
        const auto paint_range = [&](std::size_t begin, std::size_t end) {
            TriangleGauge gauge(source_.scene, source_.cloud, source_.map);
            std::uint64_t num_uncovered = 0;
            for (std::size_t i = begin; i < end; ++i) {
                const Index t = static_cast<Index>(i);
                if (is_paintable_[t] == 0) continue;
                gauge.look_at(t);
                PatchTexels texels = gauge.texels(
                    patch_layout(source_.scene.shell.frame(t), corners(t, out_.pages)));
                num_uncovered += texels.num_uncovered;
                settle_tangent(source_, t, {}, texels, out_.texture.model);
                copy(t, texels);
            }
            return num_uncovered;
        };
        out_.texture.num_uncovered = parallel_reduce(context_, mesh_.triangles.size(), kGrain,
                                                     std::uint64_t{0}, paint_range, std::plus<>());
    }

    void copy(Index t, const PatchTexels& texels) {
        const Index page = layout_.triangle_pages[t];
        Image& image = out_.texture.model.images[page];
        for_each_texel(texels.layout.corners, image, [&](int x, int y) {
            const std::size_t at = image.texel(x, y);
            const TexelOwner& owner = owners_[page][at];
            if (owner.triangle != t || owner.x != x || owner.y != y) return;
            const Texel texel = texels.texel(x - texels.need.offset_x, y - texels.need.offset_y);
            std::copy(texel.begin(), texel.end(),
                      image.pixels.begin() + static_cast<std::ptrdiff_t>(3 * at));
            out_.texture.owned[page][at] = 1;
        });
    }

    // What a triangle makes of the pages.
    struct Outcome {
        float error = 0.0F;
        CapCount cap = nullptr;  // what kept it above the bound
    };

    void measure() {
        RawErrors raw(source_);
        std::vector<Outcome> outcomes(mesh_.triangles.size());
        parallel_for(context_, outcomes.size(), kGrain, [&](std::size_t begin, std::size_t end) {
            TriangleGauge gauge(source_.scene, source_.cloud, source_.map);
            for (std::size_t i = begin; i < end; ++i)
                outcomes[i] = judge(static_cast<Index>(i), gauge, raw);
        });
        raw.summarise(out_.texture);
        report(outcomes);
    }

    // Colours are read from the page. A normal map holds vectors in each triangle's own frame: its
    // triangles are judged by what they painted.
    Outcome judge(Index t, TriangleGauge& gauge, RawErrors& raw) const {
        Outcome out;
        const TriangleFrame& frame = source_.scene.shell.frame(t);
        if (!has_area(frame.corners)) return out;
        gauge.look_at(t);
        gauge.place_probes();
        const Corners c = corners(t, out_.pages);
        const PatchLayout layout = patch_layout(frame, c);
        const auto own_error = [&] { return gauge.error(gauge.texels(layout)); };
        if (source_.map.kind == MapKind::kNormal) {
            if (is_paintable_[t] == 0) return out;
            const PatchTexels texels = gauge.texels(layout);
            raw.measure(t, texels);
            out.error = gauge.error(texels);
        } else {
            const Index page = layout_.triangle_pages[t];
            const auto read = [&](Vec2f place) {
                const std::array<double, 3> b = frame.barycentric(vec_cast<double>(place));
                return read_page(out_.texture.model.images[page],
                                 c[0] * b[0] + c[1] * b[1] + c[2] * b[2]);
            };
            raw.measure(t, read);
            out.error = gauge.error(read);
        }
        if (static_cast<double>(out.error) <= limits_.bound) return out;
        if (is_paintable_[t] == 0 || static_cast<double>(own_error()) <= limits_.bound)
            out.cap = &CappedCounts::by_layout;
        else if (pitch(layout) <= gauge.min_pitch() || size_ + 1 < num_sizes_)
            out.cap = &CappedCounts::by_spacing;
        else
            out.cap = cap_of_last_;
        return out;
    }

    void report(const std::vector<Outcome>& outcomes) {
        TextureReport& report = out_.report;
        report.bound = limits_.bound;
        report.num_patches = outcomes.size();
        for (const std::vector<TexelOwner>& page : owners_) {
            for (const TexelOwner& owner : page) {
                report.num_needed_texels += owner.triangle != kInvalidIndex ? 1 : 0;
                report.payload_texels += owner.is_inside ? 1.0 : 0.0;
                out_.num_shared_texels += owner.is_shared ? 1 : 0;
            }
        }
        std::vector<float> errors;
        std::vector<double> areas;
        for (Index t = 0; t < outcomes.size(); ++t) {
            const Outcome& o = outcomes[t];
            errors.push_back(o.error);
            areas.push_back(source_.scene.shell.frame(t).area());
            if (o.cap) ++(report.capped.*o.cap);
        }
        summarise_distribution(std::move(errors), areas, report);
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
    std::vector<std::vector<TexelOwner>> owners_;
    GivenBake out_;
};

}  // namespace

void validate(const Mesh& mesh, const GivenLayout& layout) {
    if (mesh.uvs.size() != mesh.triangles.size() || mesh.uvs.empty())
        fail(ErrorCode::kInvalidInput,
             "the mesh has no texture coordinates to bake into; without --keep-uvs it gets some");
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
                      const GivenLimits& limits, const Context& context) {
    validate(source.scene.mesh, layout);
    return Painter(source, layout, limits, context).run();
}

}  // namespace pointbake
