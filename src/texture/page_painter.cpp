#include "texture/page_painter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/message.h"
#include "core/parallel.h"
#include "core/union_find.h"
#include "texture/chart_patches.h"

namespace pointbake {
namespace {

constexpr std::size_t kGrain = 32;       // triangles per chunk
constexpr std::size_t kPoll = 1U << 14;  // triangles between two looks at the stop token
constexpr double kInside = 1e-6;         // barycentrics: nearer to an edge counts as on it
constexpr double kSameTexel = 1e-3;      // corners that lie apart by more are on other charts
// Texels finer than this share of the points' spacing show what is between the points: there the
// splats' values at their centres are as good as any.
constexpr double kCoarse = 0.6;
constexpr float kSampleWeight = 0.25F;  // four samples to a texel
constexpr float kLoosePrior = 0.05F, kFirmPrior = 1.0F;
constexpr float kPairWeight = 64.0F;

using Corners = std::array<Vec2d, 3>;

// The smallest barycentric coordinate of x. Of a triangle without an area there all is inside.
double depth_inside(const Corners& c, Vec2d x) {
    const double area = cross(c[1] - c[0], c[2] - c[0]);
    if (area == 0.0) return 1.0;
    return std::min({cross(c[1] - x, c[2] - x) / area, cross(c[2] - x, c[0] - x) / area,
                     cross(c[0] - x, c[1] - x) / area});
}

bool has_area(const PatchLayout& layout) { return cross(layout.column_x, layout.column_y) != 0.0F; }

}  // namespace

PagePainter::PagePainter(const PaintSource& source, const PageLayout& layout,
                         const Context& context)
    : source_(source),
      layout_(layout),
      context_(context),
      is_paintable_(layout.triangles.size()),
      out_(empty_pages(source, layout.pages)) {
    out_.model.triangle_materials = layout.triangle_pages;
    for (Image& image : out_.model.images) image.has_mips = layout.has_mips;
    for (std::size_t page = 0; page < layout.repeats.size(); ++page)
        out_.model.images[page].repeats = layout.repeats[page] != 0;
    for (Index t = 0; t < is_paintable_.size(); ++t)
        is_paintable_[t] =
            has_area(layout.triangles[t]) && source.scene.shell.frame(t).area() > 0.0;
}

bool PagePainter::has_texel(Index page, int x, int y) const {
    const Image& image = out_.model.images[page];
    return image.repeats || (x >= 0 && x < image.width && y >= 0 && y < image.height);
}

void PagePainter::find_owners() {
    for (const PageSize page : layout_.pages)
        owners_.emplace_back(static_cast<std::size_t>(num_texels(page)));
    for (Index t = 0; t < is_paintable_.size(); ++t) {
        if (t % kPoll == 0) check_cancelled(context_);
        if (!is_paintable(t)) continue;
        claim_inside(t);
        if (!layout_.gutters.empty()) claim_gutter(t);
    }
    for (const std::vector<TexelOwner>& page : owners_)
        for (const TexelOwner& owner : page)
            out_.report.num_needed_texels += owner.triangle != kInvalidIndex ? 1 : 0;
    for (const PatchLayout& t : layout_.triangles)
        out_.report.payload_texels +=
            0.5 * std::fabs(cross(t.corners[1] - t.corners[0], t.corners[2] - t.corners[0]));
}

void PagePainter::claim_inside(Index t) {
    const Corners& c = layout_.triangles[t].corners;
    const Index page = layout_.triangle_pages[t];
    const NeedSet need = need_set(c);
    for (int row = 0; row < need.shape.height(); ++row) {
        const PatchShape::Span span = need.shape.rows[static_cast<std::size_t>(row)];
        for (int i = span.left; i <= span.right; ++i) {
            const int x = i + need.offset_x, y = row + need.offset_y;
            if (!has_texel(page, x, y)) continue;
            const double depth = depth_inside(c, {static_cast<double>(x), static_cast<double>(y)});
            TexelOwner& owner = owners_[page][out_.model.images[page].texel(x, y)];
            if (owner.is_inside)
                owner.is_shared = owner.is_shared || depth > kInside;
            else if (depth >= -kInside)
                owner = {t, x, y, 0.0F, true, false};
            else if (owner.triangle == kInvalidIndex)
                owner = {t, x, y, HUGE_VALF, false, false};
        }
    }
}

// Where the page goes on with another part of the surface.
bool PagePainter::is_border(Index t, std::size_t k) const {
    const Index next = source_.scene.neighbors[t][k];
    if (next == kInvalidIndex || layout_.triangle_pages[next] != layout_.triangle_pages[t])
        return true;
    const Triangle& own = source_.scene.mesh.triangles[t];
    for (const std::size_t i : {k, (k + 1) % 3})
        if (length(layout_.triangles[t].corners[i] - corner_at(next, own[i])) > kSameTexel)
            return true;
    return false;
}

// Where one of a triangle's vertices lies in its page.
Vec2d PagePainter::corner_at(Index t, Index vertex) const {
    const Triangle& tri = source_.scene.mesh.triangles[t];
    const auto k = std::find(tri.begin(), tri.end(), vertex) - tri.begin();
    return layout_.triangles[t].corners[static_cast<std::size_t>(k)];
}

void PagePainter::claim_gutter(Index t) {
    const Corners& c = layout_.triangles[t].corners;
    const Index page = layout_.triangle_pages[t];
    for (std::size_t k = 0; k < 3; ++k) {
        if (!is_border(t, k)) continue;
        for_each_texel_near(
            c[k], c[(k + 1) % 3], layout_.gutters[t], [&](int x, int y, double distance) {
                if (!has_texel(page, x, y)) return;
                TexelOwner& owner = owners_[page][out_.model.images[page].texel(x, y)];
                if (owner.is_inside) return;
                const auto d = static_cast<float>(distance);
                if (owner.triangle == kInvalidIndex || d < owner.distance)
                    owner = {t, x, y, d, false, false};
            });
    }
}

// Row spans around the texels that a triangle owns; others may lie between them.
PagePainter::Owned PagePainter::owned_by(Index t) const {
    const Index page = layout_.triangle_pages[t];
    const Corners& c = layout_.triangles[t].corners;
    const int margin = static_cast<int>(std::ceil(gutter(t))) + 1;
    const auto low = [&](double a, double b, double d) {
        return static_cast<int>(std::floor(std::min({a, b, d}))) - margin;
    };
    const int x0 = low(c[0].x, c[1].x, c[2].x), x1 = -low(-c[0].x, -c[1].x, -c[2].x);
    const int y0 = low(c[0].y, c[1].y, c[2].y), y1 = -low(-c[0].y, -c[1].y, -c[2].y);
    Owned owned;
    const auto is_own = [&](int x, int y) {
        if (!has_texel(page, x, y)) return false;
        const TexelOwner& owner = owners_[page][out_.model.images[page].texel(x, y)];
        if (owner.triangle != t || owner.x != x || owner.y != y) return false;
        if (!owner.is_inside)
            owned.beyond =
                std::max(owned.beyond, std::min(static_cast<double>(owner.distance), gutter(t)));
        return true;
    };
    NeedSet& out = owned.need;
    std::vector<PatchShape::Span> rows;
    int left = x1 + 1, top = y1 + 1, bottom = y0 - 1;
    for (int y = y0; y <= y1; ++y) {
        PatchShape::Span span{x1 + 1, x0 - 1};
        for (int x = x0; x <= x1; ++x)
            if (is_own(x, y)) span.left = std::min(span.left, x), span.right = x;
        rows.push_back(span);
        if (span.left > span.right) continue;
        left = std::min(left, span.left);
        top = std::min(top, y), bottom = y;
    }
    out.offset_x = left, out.offset_y = top;
    for (int y = top; y <= bottom; ++y) {
        PatchShape::Span span = rows[static_cast<std::size_t>(y - y0)];
        if (span.left > span.right) span = {left, left};  // nothing in this row
        out.shape.rows.push_back({span.left - left, span.right - left});
    }
    return owned;
}

// The splats around a triangle are gathered once, for its texels and for the samples between them.
void PagePainter::paint(bool for_fit) {
    constexpr std::size_t kBatch = 2048;  // triangles whose samples are held at once
    for (const PageSize page : layout_.pages)
        values_.emplace_back(static_cast<std::size_t>(num_texels(page)));
    if (for_fit && source_.map.kind == MapKind::kColor) {
        fit_.emplace(layout_.pages);
        is_coarse_.assign(is_paintable_.size(), 0);
    }
    for (std::size_t first = 0; first < is_paintable_.size(); first += kBatch) {
        std::vector<std::vector<Sample>> samples(std::min(kBatch, is_paintable_.size() - first));
        const auto paint_range = [&](std::size_t begin, std::size_t end) {
            TriangleGauge gauge(source_.scene, source_.cloud, source_.map);
            std::uint64_t num_uncovered = 0;
            for (std::size_t i = begin; i < end; ++i) {
                const Index t = static_cast<Index>(first + i);
                if (!is_paintable(t)) continue;
                Owned owned = owned_by(t);
                gauge.look_at(t);
                gauge.gather(owned.beyond * layout_.triangles[t].pitch());
                num_uncovered += paint_triangle(t, gauge, std::move(owned.need));
                if (fit_) {
                    is_coarse_[t] = layout_.triangles[t].pitch() >= kCoarse * gauge.spacing();
                    if (is_coarse_[t] != 0) samples[i] = samples_of(t, gauge);
                }
            }
            return num_uncovered;
        };
        out_.report.num_uncovered_texels += parallel_reduce(
            context_, samples.size(), kGrain, std::uint64_t{0}, paint_range, std::plus<>());
        for (const std::vector<Sample>& of_triangle : samples)
            for (const Sample& s : of_triangle) fit_->add_sample(s.tap, s.wanted, kSampleWeight);
    }
    for (std::size_t page = 0; page < owners_.size(); ++page)
        for (std::size_t i = 0; i < owners_[page].size(); ++i)
            out_.owned[page][i] = owners_[page][i].triangle != kInvalidIndex;
}

std::uint64_t PagePainter::paint_triangle(Index t, const TriangleGauge& gauge, NeedSet owned) {
    PatchTexels texels = gauge.texels(layout_.triangles[t], std::move(owned));
    settle_tangent(source_, t, {}, texels, out_.model);
    return copy(t, texels);
}

// Four to a texel, splatted as if they were texels of half the size.
std::vector<PagePainter::Sample> PagePainter::samples_of(Index t,
                                                         const TriangleGauge& gauge) const {
    std::vector<Sample> out;
    const PatchLayout& layout = layout_.triangles[t];
    const Corners& c = layout.corners;
    if (cross(c[1] - c[0], c[2] - c[0]) == 0.0) return out;
    PatchLayout halves = layout;
    const auto half = [](auto x) { return x + x; };
    for (Vec2d& corner : halves.corners) corner = half(corner) + Vec2d{0.5, 0.5};
    halves.origin = half(layout.origin) + Vec2f{0.5F, 0.5F};
    halves.column_x = half(layout.column_x);
    halves.column_y = half(layout.column_y);
    const PatchTexels texels = gauge.texels(halves);
    for (int row = 0; row < texels.need.shape.height(); ++row) {
        const PatchShape::Span span = texels.need.shape.rows[static_cast<std::size_t>(row)];
        for (int j = span.left; j <= span.right; ++j) {
            const Vec2d place = (Vec2d{static_cast<double>(j + texels.need.offset_x),
                                       static_cast<double>(row + texels.need.offset_y)} -
                                 Vec2d{0.5, 0.5}) *
                                0.5;
            if (depth_inside(c, place) < -kInside) continue;
            if (const auto tap = fit_->tap(layout_.triangle_pages[t], place))
                out.push_back({*tap, texels.value(j, row)});
        }
    }
    return out;
}

// How many of its texels inside the triangle no splat reached.
std::uint64_t PagePainter::copy(Index t, const PatchTexels& texels) {
    std::uint64_t num_uncovered = 0;
    const Index page = layout_.triangle_pages[t];
    Image& image = out_.model.images[page];
    for (int row = 0; row < texels.need.shape.height(); ++row) {
        const PatchShape::Span span = texels.need.shape.rows[static_cast<std::size_t>(row)];
        for (int i = span.left; i <= span.right; ++i) {
            const int x = i + texels.need.offset_x, y = row + texels.need.offset_y;
            if (!has_texel(page, x, y)) continue;
            const std::size_t at = image.texel(x, y);
            const TexelOwner& owner = owners_[page][at];
            if (owner.triangle != t || owner.x != x || owner.y != y) continue;
            const Texel texel = texels.texel(i, row);
            values_[page][at] = texels.value(i, row);
            if (owner.is_inside && texels.is_uncovered[texels.at(i, row)] != 0) ++num_uncovered;
            std::copy(texel.begin(), texel.end(),
                      image.pixels.begin() + static_cast<std::ptrdiff_t>(3 * at));
        }
    }
    return num_uncovered;
}

void PagePainter::fit() {
    if (!fit_) return;
    add_priors();
    for (Index t = 0; t < is_paintable_.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k) add_border(t, k);
    values_ = fit_->solve(values_, context_);
    fit_.reset();
    for (std::size_t page = 0; page < values_.size(); ++page) {
        Image& image = out_.model.images[page];
        parallel_for(context_, values_[page].size(), std::size_t{1} << 14,
                     [&](std::size_t begin, std::size_t end) {
                         for (std::size_t i = begin; i < end; ++i) {
                             if (owners_[page][i].triangle == kInvalidIndex) continue;
                             const Texel texel = encode(MapKind::kColor, values_[page][i]);
                             std::copy(texel.begin(), texel.end(),
                                       image.pixels.begin() + static_cast<std::ptrdiff_t>(3 * i));
                         }
                     });
    }
}

// Texels are held to what was painted: loosely where samples say what is wanted.
void PagePainter::add_priors() {
    for (Index page = 0; page < owners_.size(); ++page)
        for (std::size_t i = 0; i < owners_[page].size(); ++i) {
            const Index t = owners_[page][i].triangle;
            if (t != kInvalidIndex)
                fit_->add_prior(page, i, is_coarse_[t] != 0 ? kLoosePrior : kFirmPrior);
        }
}

// Both sides of a border edge, twice to a texel.
void PagePainter::add_border(Index t, std::size_t k) {
    const Index next = source_.scene.neighbors[t][k];
    if (next == kInvalidIndex || next < t || !is_border(t, k)) return;
    if (!is_paintable(t) || !is_paintable(next)) return;
    const Triangle& own = source_.scene.mesh.triangles[t];
    const Vec2d a = layout_.triangles[t].corners[k], b = layout_.triangles[t].corners[(k + 1) % 3];
    const Vec2d c = corner_at(next, own[k]), d = corner_at(next, own[(k + 1) % 3]);
    const int count =
        std::max(1, static_cast<int>(std::ceil(2.0 * std::max(length(b - a), length(d - c)))));
    for (int i = 0; i < count; ++i) {
        const double s = (i + 0.5) / count;
        const auto here = fit_->tap(layout_.triangle_pages[t], a + (b - a) * s);
        const auto there = fit_->tap(layout_.triangle_pages[next], c + (d - c) * s);
        if (here && there) fit_->add_pair(*here, *there, kPairWeight);
    }
}

void PagePainter::finish(
    const std::function<void(Image&, std::span<const std::uint8_t>)>& finish_page) {
    if (!finish_page) return;
    std::vector<Image> exact = out_.model.images;
    bool is_coded = false;
    for (std::size_t page = 0; page < exact.size(); ++page) {
        check_cancelled(context_);
        finish_page(out_.model.images[page], out_.owned[page]);
        is_coded = is_coded || !out_.model.images[page].file.empty();
    }
    if (is_coded) exact_ = std::move(exact);
}

// Bilinear, in linear light, as hardware reads a page of colours.
Vec3f PagePainter::read_page(std::span<const Image> pages, Index t, Vec2f place) const {
    const Image& page = pages[layout_.triangle_pages[t]];
    // Single floats are too coarse for a place among thousands of texels.
    const std::array<double, 3> b =
        source_.scene.shell.frame(t).barycentric(vec_cast<double>(place));
    const Corners& c = layout_.triangles[t].corners;
    const Vec2d texel = c[0] * b[0] + c[1] * b[1] + c[2] * b[2];
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

bool PagePainter::is_lost_by_format(Index t, double bound, TriangleGauge& gauge) const {
    if (exact_.empty()) return false;
    gauge.look_at(t);
    gauge.place_probes();
    const auto read = [&](Vec2f place) { return read_page(exact_, t, place); };
    return static_cast<double>(gauge.error(read)) <= bound;
}

// Colours are read from the pages. A normal map holds vectors in each triangle's own frame: its
// triangles are judged by what they painted.
void PagePainter::measure(double bound, const std::function<CapCount(Index, TriangleGauge&)>& cap) {
    RawErrors raw(source_);
    const std::size_t num_triangles = is_paintable_.size();
    std::vector<PointError> at_points(num_triangles);
    std::vector<double> areas(num_triangles);
    parallel_for(context_, num_triangles, kGrain, [&](std::size_t begin, std::size_t end) {
        TriangleGauge gauge(source_.scene, source_.cloud, source_.map, source_.is_paper);
        for (std::size_t i = begin; i < end; ++i) {
            const Index t = static_cast<Index>(i);
            areas[t] = source_.scene.shell.frame(t).area();
            if (!(areas[t] > 0.0)) continue;
            gauge.look_at(t);
            gauge.place_probes();
            at_points[t] = {gauge.num_probes(), gauge.probed_area(), 0.0F};
            if (source_.map.kind == MapKind::kNormal) {
                if (!is_paintable(t)) continue;
                gauge.gather();
                const PatchTexels texels = gauge.texels(layout_.triangles[t]);
                raw.measure(t, texels);
                at_points[t].rms = gauge.error(texels);
            } else {
                const auto read = [&](Vec2f place) {
                    return read_page(out_.model.images, t, place);
                };
                raw.measure(t, read);
                at_points[t].rms = gauge.error(read);
            }
        }
    });
    TextureReport& report = out_.report;
    report.bound = bound;
    raw.summarise(report);
    std::vector<float> errors = pool_small(at_points);
    std::vector<CapCount> caps(num_triangles, nullptr);
    parallel_for(context_, num_triangles, kGrain, [&](std::size_t begin, std::size_t end) {
        TriangleGauge gauge(source_.scene, source_.cloud, source_.map, source_.is_paper);
        for (std::size_t i = begin; i < end; ++i) {
            const Index t = static_cast<Index>(i);
            if (static_cast<double>(errors[t]) <= bound) continue;
            caps[t] = is_lost_by_format(t, bound, gauge) ? &CappedCounts::by_format : cap(t, gauge);
        }
    });
    for (const CapCount c : caps) {
        if (c) ++(report.capped.*c);
        out_.is_missed.push_back(c == &CappedCounts::by_layout ? 1 : 0);
    }
    errors_ = errors;
    summarise_distribution(std::move(errors), areas, report);
    report.densities = densities(areas);
}

std::vector<TextureReport::Density> PagePainter::densities(std::span<const double> areas) const {
    std::map<int, double> by_octave;
    double whole = 0.0;
    for (Index t = 0; t < areas.size(); ++t) {
        if (!is_paintable(t)) continue;
        by_octave[std::ilogb(1.0 / layout_.triangles[t].pitch())] += areas[t];
        whole += areas[t];
    }
    std::vector<TextureReport::Density> out;
    for (const auto& [octave, area] : by_octave)
        out.push_back({std::ldexp(1.0, octave), area / whole});
    return out;
}

void PagePainter::draw_debug_maps() {
    constexpr float kGreyPerStep = 16.0F;
    constexpr double kGreyPerOctave = 32.0, kMedianGrey = 128.0;
    std::vector<double> densities;
    for (Index t = 0; t < errors_.size(); ++t)
        if (is_paintable(t)) densities.push_back(1.0 / layout_.triangles[t].pitch());
    if (densities.empty()) return;
    const auto middle = densities.begin() + static_cast<std::ptrdiff_t>(densities.size() / 2);
    std::nth_element(densities.begin(), middle, densities.end());
    const auto grey = [](double v) { return static_cast<std::uint8_t>(std::clamp(v, 0.0, 255.0)); };
    for (std::size_t page = 0; page < owners_.size(); ++page) {
        const PageSize size = layout_.pages[page];
        const auto map = [&](const char* name, auto&& value) {
            Image image{size.width, size.height, 1, {}};
            for (const TexelOwner& owner : owners_[page])
                image.pixels.push_back(owner.triangle == kInvalidIndex ? 0 : value(owner));
            out_.debug_maps.push_back({fmt::format("{}-{}", name, page), std::move(image)});
        };
        map("coverage", [&](const TexelOwner& owner) { return grey(owner.is_inside ? 255 : 96); });
        map("error", [&](const TexelOwner& owner) {
            return grey(static_cast<double>(kGreyPerStep * errors_[owner.triangle]));
        });
        map("density", [&](const TexelOwner& owner) {
            const double ratio = 1.0 / layout_.triangles[owner.triangle].pitch() / *middle;
            return grey(kMedianGrey + kGreyPerOctave * std::log2(ratio));
        });
    }
}

// Few points make no RMS: triangles with fewer than that are judged as one with the neighbour
// behind their longest side, and so on until there are enough.
std::vector<float> PagePainter::pool_small(std::span<const PointError> at_points) const {
    constexpr std::size_t kEnoughPoints = 8;
    struct Pool {
        std::size_t num_points = 0;
        double squares = 0.0, area = 0.0;
        Index next = kInvalidIndex;  // triangle behind the longest side
        double longest = -1.0;
    };
    const auto num_triangles = static_cast<Index>(at_points.size());
    UnionFind groups(num_triangles);
    std::vector<float> out(num_triangles, 0.0F);
    std::vector<Pool> pools;
    for (bool has_changed = true; has_changed;) {
        has_changed = false;
        pools.assign(num_triangles, {});
        for (Index t = 0; t < num_triangles; ++t) {
            Pool& pool = pools[groups.find(t)];
            const PointError& e = at_points[t];
            pool.num_points += e.num_points;
            pool.squares += e.area * static_cast<double>(e.rms) * static_cast<double>(e.rms);
            pool.area += e.area;
            const auto& corners = source_.scene.shell.frame(t).corners;
            for (std::size_t k = 0; k < 3; ++k) {
                const Index next = source_.scene.neighbors[t][k];
                const double side = length(corners[(k + 1) % 3] - corners[k]);
                if (next != kInvalidIndex && groups.find(next) != groups.find(t) &&
                    side > pool.longest)
                    pool.longest = side, pool.next = next;
            }
        }
        // Counts are kept up to date, so that no pool grows once it has enough.
        for (Index t = 0; t < num_triangles; ++t) {
            if (groups.find(t) != t || pools[t].num_points >= kEnoughPoints ||
                pools[t].next == kInvalidIndex)
                continue;
            const Index next = groups.find(pools[t].next);
            if (next == t) continue;
            const std::size_t num_points = pools[t].num_points + pools[next].num_points;
            groups.unite(t, next);
            pools[groups.find(t)].num_points = num_points;
            has_changed = true;
        }
    }
    for (Index t = 0; t < num_triangles; ++t) {
        const Pool& pool = pools[groups.find(t)];
        if (pool.area > 0.0) out[t] = static_cast<float>(std::sqrt(pool.squares / pool.area));
    }
    return out;
}

std::uint64_t PagePainter::num_shared() const {
    std::uint64_t sum = 0;
    for (const std::vector<TexelOwner>& page : owners_)
        for (const TexelOwner& owner : page) sum += owner.is_shared ? 1 : 0;
    return sum;
}

}  // namespace pointbake
