// Each triangle tells the smallest size that it is content with; the largest of those is taken.
#include "texture/given_layout.h"

#include <algorithm>
#include <cmath>

#include "core/message.h"
#include "core/parallel.h"
#include "texture/level_errors.h"

namespace pointbake {
namespace {

constexpr std::size_t kGrain = 32;  // triangles per chunk
constexpr int kPageStep = 64;
constexpr float kRounding = 1e-4F;  // texture coordinates beyond the page by less do not repeat it
constexpr float kFarthest = 16.0F;  // beyond, a layout is a pattern
constexpr float kNothingToGain = 0.35F;  // 8-bit rounding alone is 0.29
constexpr double kInside = 1e-6;         // barycentrics: nearer to an edge counts as on it
constexpr double kLeastArea = 1e-12;     // of the page: less is a line

// Visits the texels that a triangle needs: x, y as its corners have them, and the place in the
// page; those beyond a page that does not repeat are left out.
template <class Visit>
void for_each_texel(const std::array<Vec2d, 3>& corners, const PageSize& page, bool repeats,
                    Visit&& visit) {
    const auto wrapped = [](int i, int size) { return ((i % size) + size) % size; };
    const NeedSet need = need_set(corners);
    for (int row = 0; row < need.shape.height(); ++row) {
        const int y = row + need.offset_y;
        if (!repeats && (y < 0 || y >= page.height)) continue;
        const PatchShape::Span span = need.shape.rows[static_cast<std::size_t>(row)];
        int first = span.left + need.offset_x, last = span.right + need.offset_x;
        if (!repeats) first = std::max(first, 0), last = std::min(last, page.width - 1);
        const auto start = static_cast<std::size_t>(wrapped(y, page.height)) *
                           static_cast<std::size_t>(page.width);
        for (int x = first; x <= last; ++x)
            visit(x, y, start + static_cast<std::size_t>(wrapped(x, page.width)));
    }
}

std::array<Vec2d, 3> texels_of(const std::array<Vec2f, 3>& uvs, const PageSize& page) {
    std::array<Vec2d, 3> out;
    for (std::size_t k = 0; k < 3; ++k)
        out[k] = {static_cast<double>(uvs[k].x) * page.width - 0.5,
                  static_cast<double>(uvs[k].y) * page.height - 0.5};
    return out;
}

// The smallest barycentric coordinate of x.
double depth_inside(const std::array<Vec2d, 3>& c, Vec2d x) {
    const double area = cross(c[1] - c[0], c[2] - c[0]);
    return std::min({cross(c[1] - x, c[2] - x) / area, cross(c[2] - x, c[0] - x) / area,
                     cross(c[0] - x, c[1] - x) / area});
}

using Pages = std::vector<PageSize>;

std::int64_t num_texels(const Pages& pages) {
    std::int64_t sum = 0;
    for (const PageSize& p : pages) sum += std::int64_t{p.width} * p.height;
    return sum;
}

// Pages in their proportions, the longest side as given, all sides multiples of 64.
Pages scaled_pages(const GivenLayout& layout, double side) {
    int longest = 1;
    for (const GivenLayout::Page& p : layout.pages)
        longest = std::max({longest, p.proportions.width, p.proportions.height});
    const auto scaled = [&](int length) {
        return kPageStep * std::max(1, static_cast<int>(side * length / longest / kPageStep + 0.5));
    };
    Pages pages;
    for (const GivenLayout::Page& p : layout.pages)
        pages.push_back({scaled(p.proportions.width), scaled(p.proportions.height)});
    return pages;
}

// Sizes that the pages may take, from small to large: the longest side sqrt(2) longer each time,
// and last the largest one that page size and budget allow.
std::vector<Pages> page_sizes(const GivenLayout& layout, const GivenLimits& limits) {
    int largest = limits.page_size / kPageStep * kPageStep;
    while (largest > kPageStep && num_texels(scaled_pages(layout, largest)) > limits.max_texels)
        largest -= kPageStep;
    std::vector<Pages> out;
    for (int step = 0;; ++step) {
        const double side =
            std::ldexp(step % 2 == 1 ? 1.4142135623730951 : 1.0, step / 2) * kPageStep;
        if (side >= largest) break;
        Pages pages = scaled_pages(layout, side);
        if (out.empty() || num_texels(pages) > num_texels(out.back()))
            out.push_back(std::move(pages));
    }
    out.push_back(scaled_pages(layout, largest));
    return out;
}

// Whether the triangle covers any area of the page.
bool covers_area(const std::array<Vec2f, 3>& uvs) {
    const Vec2d a = vec_cast<double>(uvs[0]);
    return std::fabs(cross(vec_cast<double>(uvs[1]) - a, vec_cast<double>(uvs[2]) - a)) >
           kLeastArea;
}

// Per page and texel the triangle that paints it: the first that covers its centre, else the first
// that needs it.
struct TexelOwners {
    std::vector<std::vector<Index>> pages;
    std::uint64_t num_shared = 0;  // texels whose centre lies inside several triangles
};

TexelOwners find_texel_owners(const Mesh& mesh, const GivenLayout& layout, const Pages& pages,
                              const std::vector<bool>& repeats) {
    TexelOwners out;
    std::vector<std::vector<std::uint8_t>> is_inside;
    for (const PageSize& page : pages) {
        const std::size_t n =
            static_cast<std::size_t>(page.width) * static_cast<std::size_t>(page.height);
        out.pages.emplace_back(n, kInvalidIndex);
        is_inside.emplace_back(n, std::uint8_t{0});
    }
    for (Index t = 0; t < mesh.triangles.size(); ++t) {
        if (!covers_area(mesh.uvs[t])) continue;
        const Index page = layout.triangle_pages[t];
        const std::array<Vec2d, 3> corners = texels_of(mesh.uvs[t], pages[page]);
        for_each_texel(corners, pages[page], repeats[page], [&](int x, int y, std::size_t at) {
            const double depth =
                depth_inside(corners, {static_cast<double>(x), static_cast<double>(y)});
            Index& owner = out.pages[page][at];
            if (is_inside[page][at] != 0) {
                out.num_shared += depth > kInside ? 1 : 0;
            } else if (depth >= -kInside) {
                owner = t;
                is_inside[page][at] = 1;
            } else if (owner == kInvalidIndex) {
                owner = t;
            }
        });
    }
    return out;
}

void check(const Mesh& mesh, const GivenLayout& layout) {
    if (mesh.uvs.size() != mesh.triangles.size() || mesh.uvs.empty())
        fail(ErrorCode::kInvalidInput,
             "the mesh has no texture coordinates to bake into; without --keep-uvs it gets some");
    if (layout.triangle_pages.size() != mesh.triangles.size())
        fail(ErrorCode::kInvalidInput, "{} triangles, but {} pages of theirs",
             mesh.triangles.size(), layout.triangle_pages.size());
    for (std::size_t t = 0; t < mesh.uvs.size(); ++t) {
        for (const Vec2f uv : mesh.uvs[t]) {
            if (std::max(std::fabs(uv.x), std::fabs(uv.y)) <= kFarthest) continue;
            fail(ErrorCode::kInvalidInput,
                 "triangle {} has the texture coordinates ({:.4g}, {:.4g}): up to {} is accepted; "
                 "without --keep-uvs a new layout is made",
                 t, uv.x, uv.y, kFarthest);
        }
    }
}

// Per page: do texture coordinates leave it?
std::vector<bool> find_repeating(const Mesh& mesh, const GivenLayout& layout) {
    std::vector<bool> out(layout.pages.size(), false);
    for (std::size_t t = 0; t < mesh.uvs.size(); ++t)
        for (const Vec2f uv : mesh.uvs[t])
            if (std::min(uv.x, uv.y) < -kRounding || std::max(uv.x, uv.y) > 1.0F + kRounding)
                out[layout.triangle_pages[t]] = true;
    return out;
}

class Painter {
 public:
    Painter(const PaintSource& source, const GivenLayout& layout, const GivenLimits& limits,
            const Context& context)
        : source_(source),
          mesh_(source.scene.mesh),
          layout_(layout),
          limits_(limits),
          context_(context),
          repeats_(find_repeating(mesh_, layout)),
          sizes_(page_sizes(layout, limits)) {
        if (num_texels(sizes_.front()) > limits.max_texels)
            fail(ErrorCode::kLimit, "--texels {}: the smallest pages of this layout have {}",
                 limits.max_texels, num_texels(sizes_.front()));
    }

    GivenBake run() {
        const std::size_t size = content_size();
        GivenBake out;
        out.pages = sizes_[size];
        out.texture = empty_pages(source_, out.pages);
        out.texture.model.mesh.uvs = mesh_.uvs;
        out.texture.model.triangle_materials = layout_.triangle_pages;
        for (std::size_t i = 0; i < out.pages.size(); ++i) {
            out.texture.model.materials[i].name = layout_.pages[i].name;
            out.texture.model.images[i].repeats = repeats_[i];
        }
        const TexelOwners owners = find_texel_owners(mesh_, layout_, out.pages, repeats_);
        out.num_shared_texels = owners.num_shared;
        paint(owners, out);
        return out;
    }

 private:
    // What a triangle makes of the pages that it was painted on.
    struct Outcome {
        float error = 0.0F;
        CapReason cap = CapReason::kNone;
        double texels = 0.0;
    };

    PatchLayout patch(Index triangle, const Pages& pages) const {
        return patch_layout(
            source_.scene.shell.frame(triangle),
            texels_of(mesh_.uvs[triangle], pages[layout_.triangle_pages[triangle]]));
    }
    static double pitch(const PatchLayout& layout) {
        return 1.0 /
               std::sqrt(std::fabs(static_cast<double>(cross(layout.column_x, layout.column_y))));
    }
    bool is_paintable(Index t) const {
        return covers_area(mesh_.uvs[t]) && source_.scene.shell.frame(t).area() > 0.0;
    }

    // The smallest size that every triangle is content with.
    std::size_t content_size() const {
        const auto wish = [&](std::size_t begin, std::size_t end) {
            TriangleGauge gauge(source_.scene, source_.cloud, source_.kind, source_.sharpened);
            std::size_t largest = 0;
            for (std::size_t i = begin; i < end; ++i) {
                const Index t = static_cast<Index>(i);
                if (!is_paintable(t) || source_.scene.prints.of(t).empty()) continue;
                gauge.look_at(t);
                gauge.place_probes();
                while (largest + 1 < sizes_.size() && !is_content(gauge, t, largest)) ++largest;
            }
            return largest;
        };
        return parallel_reduce(context_, mesh_.triangles.size(), kGrain, std::size_t{0}, wish,
                               [](std::size_t a, std::size_t b) { return std::max(a, b); });
    }

    bool is_content(const TriangleGauge& gauge, Index t, std::size_t size) const {
        const PatchLayout layout = patch(t, sizes_[size]);
        if (pitch(layout) <= gauge.min_pitch()) return true;
        const auto wanted = static_cast<double>(kNothingToGain);
        return static_cast<double>(gauge.error(gauge.texels(layout))) <=
               (limits_.bound < HUGE_VAL ? std::max(limits_.bound, wanted) : wanted);
    }

    void paint(const TexelOwners& owners, GivenBake& out) const {
        RawErrors raw(source_);
        std::vector<Outcome> outcomes(mesh_.triangles.size());
        const auto paint_range = [&](std::size_t begin, std::size_t end) {
            TriangleGauge gauge(source_.scene, source_.cloud, source_.kind, source_.sharpened);
            std::uint64_t num_uncovered = 0;
            for (std::size_t i = begin; i < end; ++i) {
                const Index t = static_cast<Index>(i);
                if (!is_paintable(t)) continue;
                gauge.look_at(t);
                gauge.place_probes();
                PatchTexels texels = gauge.texels(patch(t, out.pages));
                num_uncovered += texels.num_uncovered;
                raw.measure(t, texels);
                outcomes[t] = judge(gauge, texels);
                settle_tangent(source_, t, {}, texels, out.texture.model);
                copy(t, texels, owners, out.texture);
            }
            return num_uncovered;
        };
        out.texture.num_uncovered = parallel_reduce(context_, mesh_.triangles.size(), kGrain,
                                                    std::uint64_t{0}, paint_range, std::plus<>());
        raw.summarise(out.texture);
        out.report = report(outcomes);
        for (const std::vector<Index>& page : owners.pages)
            out.report.num_needed_texels += static_cast<std::uint64_t>(
                page.size() - static_cast<std::size_t>(std::ranges::count(page, kInvalidIndex)));
    }

    Outcome judge(const TriangleGauge& gauge, const PatchTexels& texels) const {
        Outcome out;
        out.error = gauge.error(texels);
        const std::array<Vec2d, 3>& c = texels.layout.corners;
        out.texels = 0.5 * std::fabs(cross(c[1] - c[0], c[2] - c[0]));
        if (static_cast<double>(out.error) <= limits_.bound) return out;
        const bool is_fine = pitch(texels.layout) <= gauge.min_pitch();
        out.cap = is_fine ? CapReason::kSpacing : CapReason::kSize;
        return out;
    }

    void copy(Index t, const PatchTexels& texels, const TexelOwners& owners,
              BakedTexture& out) const {
        const Index page = layout_.triangle_pages[t];
        Image& image = out.model.images[page];
        for_each_texel(texels.layout.corners, {image.width, image.height}, repeats_[page],
                       [&](int x, int y, std::size_t at) {
                           if (owners.pages[page][at] != t) return;
                           const Texel texel =
                               texels.texel(x - texels.need.offset_x, y - texels.need.offset_y);
                           std::copy(texel.begin(), texel.end(),
                                     image.pixels.begin() + static_cast<std::ptrdiff_t>(3 * at));
                           out.owned[page][at] = 1;
                       });
    }

    TextureReport report(const std::vector<Outcome>& outcomes) const {
        TextureReport out;
        out.bound = limits_.bound;
        out.num_patches = outcomes.size();
        const bool is_cut =
            num_texels(scaled_pages(layout_, limits_.page_size)) > limits_.max_texels;
        std::vector<float> errors;
        std::vector<double> areas;
        for (Index t = 0; t < outcomes.size(); ++t) {
            const Outcome& o = outcomes[t];
            errors.push_back(o.error);
            areas.push_back(source_.scene.shell.frame(t).area());
            out.payload_texels += o.texels;
            if (o.cap == CapReason::kSpacing) ++out.capped.by_spacing;
            if (o.cap == CapReason::kSize) ++(is_cut ? out.capped.by_budget : out.capped.by_size);
        }
        summarise_distribution(std::move(errors), areas, out);
        return out;
    }

    PaintSource source_;
    const Mesh& mesh_;
    const GivenLayout& layout_;
    GivenLimits limits_;
    const Context& context_;
    std::vector<bool> repeats_;
    std::vector<Pages> sizes_;
};

}  // namespace

GivenBake paint_given(const PaintSource& source, const GivenLayout& layout,
                      const GivenLimits& limits, const Context& context) {
    check(source.scene.mesh, layout);
    return Painter(source, layout, limits, context).run();
}

}  // namespace pointbake
