#include "texture/texel_fit.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/parallel.h"

namespace pointbake {
namespace {

constexpr std::size_t kGrain = 1 << 13;  // unknowns per chunk
constexpr int kMaxSteps = 40;
constexpr double kPrecision = 1e-4;  // residual over that of the start

using Vector = std::vector<Vec3f>;

double dot_all(const Vector& a, const Vector& b, const Context& context) {
    return parallel_reduce(
        context, a.size(), kGrain, 0.0,
        [&](std::size_t begin, std::size_t end) {
            double part = 0.0;
            for (std::size_t i = begin; i < end; ++i) part += static_cast<double>(dot(a[i], b[i]));
            return part;
        },
        std::plus<>());
}

template <class Update>
void for_all(std::size_t size, const Context& context, Update&& update) {
    parallel_for(context, size, kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) update(i);
    });
}

}  // namespace

TexelFit::TexelFit(std::span<const PageSize> pages) : pages_(pages.begin(), pages.end()) {
    std::size_t size = 0;
    for (const PageSize& page : pages_) {
        first_of_page_.push_back(size);
        size += static_cast<std::size_t>(num_texels(page));
    }
    matrix_.resize(size);
    prior_.resize(size);
    right_.resize(size);
}

std::optional<TexelFit::Tap> TexelFit::tap(Index page, Vec2d texel) const {
    const PageSize size = pages_[page];
    const double right = size.width - 1, lower = size.height - 1;
    if (size.width < 2 || size.height < 2) return std::nullopt;
    if (!(texel.x >= 0.0 && texel.y >= 0.0 && texel.x <= right && texel.y <= lower))
        return std::nullopt;
    // The last column and row are read as the far ones of the four.
    const double x0 = std::min(std::floor(texel.x), right - 1.0);
    const double y0 = std::min(std::floor(texel.y), lower - 1.0);
    const auto fx = static_cast<float>(texel.x - x0), fy = static_cast<float>(texel.y - y0);
    const std::size_t first = static_cast<std::size_t>(y0) * static_cast<std::size_t>(size.width) +
                              static_cast<std::size_t>(x0);
    return Tap{
        page, first, {(1.0F - fx) * (1.0F - fy), fx * (1.0F - fy), (1.0F - fx) * fy, fx * fy}};
}

std::array<std::size_t, 4> TexelFit::texels_of(const Tap& tap) const {
    const std::size_t first = first_of_page_[tap.page] + tap.first;
    const auto below = first + static_cast<std::size_t>(pages_[tap.page].width);
    return {first, first + 1, below, below + 1};
}

void TexelFit::scatter(const Tap& tap, Vec3f value, Vector& to) const {
    const std::array<std::size_t, 4> at = texels_of(tap);
    for (std::size_t k = 0; k < 4; ++k) to[at[k]] += value * tap.weights[k];
}

void TexelFit::add_sample(const Tap& tap, Vec3f wanted, float weight) {
    scatter(tap, wanted * weight, right_);
    const auto [upper_left, upper_right, lower_left, lower_right] = texels_of(tap);
    const auto [a, b, c, d] = tap.weights;
    matrix_[upper_left].self += weight * a * a;
    matrix_[upper_right].self += weight * b * b;
    matrix_[lower_left].self += weight * c * c;
    matrix_[lower_right].self += weight * d * d;
    matrix_[upper_left].right += weight * a * b;
    matrix_[lower_left].right += weight * c * d;
    matrix_[upper_left].lower += weight * a * c;
    matrix_[upper_right].lower += weight * b * d;
    matrix_[upper_left].lower_right += weight * a * d;
    matrix_[upper_right].lower_left += weight * b * c;
}

void TexelFit::add_pair(const Tap& a, const Tap& b, float weight) {
    pairs_.push_back({a, b, weight});
}

void TexelFit::add_prior(Index page, std::size_t texel, float weight) {
    prior_[first_of_page_[page] + texel] += weight;
}

// Minus the gradient at the start: what samples and pairs ask for beyond what it shows. (The prior
// asks for nothing there.)
Vector TexelFit::misfit(const Values& start) const {
    Vector out = right_;
    for (std::size_t page = 0; page < pages_.size(); ++page) {
        const std::size_t first = first_of_page_[page];
        const auto width = static_cast<std::size_t>(pages_[page].width);
        const std::vector<Vec3f>& values = start[page];
        for (std::size_t i = 0; i < values.size(); ++i) {
            const Stencil& m = matrix_[first + i];
            if (!(m.self > 0.0F)) continue;
            out[first + i] -= values[i] * m.self;
            const auto add = [&](std::size_t other, float weight) {
                if (weight == 0.0F) return;
                out[first + i] -= values[other] * weight;
                out[first + other] -= values[i] * weight;
            };
            add(i + 1, m.right);
            add(i + width - 1, m.lower_left);
            add(i + width, m.lower);
            add(i + width + 1, m.lower_right);
        }
    }
    const auto read = [&](const Tap& tap) {
        Vec3f sum;
        const std::array<std::size_t, 4> at = texels_of(tap);
        for (std::size_t k = 0; k < 4; ++k)
            sum += start[tap.page][at[k] - first_of_page_[tap.page]] * tap.weights[k];
        return sum;
    };
    for (const Pair& pair : pairs_) {
        const Vec3f difference = (read(pair.b) - read(pair.a)) * pair.weight;
        scatter(pair.a, difference, out);
        scatter(pair.b, difference * -1.0F, out);
    }
    return out;
}

/// The equations of the texels that samples or pairs move.
class TexelFit::System {
 public:
    explicit System(const TexelFit& fit) : fit_(fit), number_(fit.matrix_.size(), kInvalidIndex) {
        std::vector<std::uint8_t> is_moved(number_.size(), 0);
        for (std::size_t i = 0; i < is_moved.size(); ++i) is_moved[i] = fit.matrix_[i].self > 0.0F;
        for (const Pair& pair : fit.pairs_)
            for (const Tap& tap : {pair.a, pair.b})
                for (const std::size_t i : fit.texels_of(tap)) is_moved[i] = 1;
        for (std::size_t page = 0; page < fit.pages_.size(); ++page) {
            const std::size_t first = fit.first_of_page_[page];
            const auto width = static_cast<std::size_t>(fit.pages_[page].width);
            const auto count = static_cast<std::size_t>(num_texels(fit.pages_[page]));
            for (std::size_t i = 0; i < count; ++i) {
                if (is_moved[first + i] == 0 || !(fit.prior_[first + i] > 0.0F)) continue;
                number_[first + i] = static_cast<Index>(texels_.size());
                texels_.push_back(first + i);
                rows_.push_back(width);
            }
        }
        for (const Pair& pair : fit.pairs_) pairs_.push_back({ends(pair.a), ends(pair.b)});
        find_pulls();
    }

    std::size_t size() const { return texels_.size(); }
    std::size_t texel(std::size_t i) const { return texels_[i]; }

    std::vector<float> inverse_diagonal() const {
        std::vector<float> out(size());
        for (std::size_t i = 0; i < size(); ++i)
            out[i] = fit_.prior_[texels_[i]] + fit_.matrix_[texels_[i]].self;
        for (std::size_t p = 0; p < pairs_.size(); ++p)
            for (const Ends& e : {pairs_[p].first, pairs_[p].second})
                for (std::size_t k = 0; k < 4; ++k)
                    if (e.at[k] != kInvalidIndex)
                        out[e.at[k]] += fit_.pairs_[p].weight * e.weights[k] * e.weights[k];
        for (float& d : out) d = 1.0F / d;
        return out;
    }

    void multiply(const Vector& x, Vector& out, const Context& context) {
        const std::vector<Stencil>& m = fit_.matrix_;
        for_all(pairs_.size(), context, [&](std::size_t p) {
            differences_[p] =
                (read(x, pairs_[p].first) - read(x, pairs_[p].second)) * fit_.pairs_[p].weight;
        });
        for_all(size(), context, [&](std::size_t i) {
            const std::size_t t = texels_[i], w = rows_[i];
            Vec3f sum = x[i] * (m[t].self + fit_.prior_[t]);
            const auto add = [&](std::size_t to, float weight) {
                if (weight != 0.0F && number_[to] != kInvalidIndex) sum += x[number_[to]] * weight;
            };
            if (m[t].self > 0.0F) {
                add(t + 1, m[t].right);
                add(t + w - 1, m[t].lower_left);
                add(t + w, m[t].lower);
                add(t + w + 1, m[t].lower_right);
                if (t > 0) add(t - 1, m[t - 1].right);
                if (t > w) add(t - w - 1, m[t - w - 1].lower_right);
                if (t >= w) add(t - w, m[t - w].lower);
                if (t >= w - 1) add(t - w + 1, m[t - w + 1].lower_left);
            }
            for (Index k = pull_begin_[i]; k < pull_begin_[i + 1]; ++k)
                sum += differences_[pulls_[k].pair] * pulls_[k].weight;
            out[i] = sum;
        });
    }

 private:
    struct Ends {
        std::array<Index, 4> at;
        std::array<float, 4> weights;
    };
    struct Pull {
        Index pair;
        float weight;  // negative at the pair's second end
    };
    Ends ends(const Tap& tap) const {
        Ends out{{}, tap.weights};
        const std::array<std::size_t, 4> texels = fit_.texels_of(tap);
        for (std::size_t k = 0; k < 4; ++k) out.at[k] = number_[texels[k]];
        return out;
    }
    static Vec3f read(const Vector& x, const Ends& e) {
        Vec3f sum;
        for (std::size_t k = 0; k < 4; ++k)
            if (e.at[k] != kInvalidIndex) sum += x[e.at[k]] * e.weights[k];
        return sum;
    }
    // For each texel the pairs that pull at it.
    void find_pulls() {
        const auto for_each_pull = [&](auto&& visit) {
            for (Index p = 0; p < pairs_.size(); ++p)
                for (const auto& [end, sign] :
                     {std::pair(&pairs_[p].first, 1.0F), std::pair(&pairs_[p].second, -1.0F)})
                    for (std::size_t k = 0; k < 4; ++k)
                        if (end->at[k] != kInvalidIndex)
                            visit(end->at[k], Pull{p, sign * end->weights[k]});
        };
        differences_.resize(pairs_.size());
        pull_begin_.assign(size() + 1, 0);
        for_each_pull([&](Index texel, Pull) { ++pull_begin_[texel + 1]; });
        std::partial_sum(pull_begin_.begin(), pull_begin_.end(), pull_begin_.begin());
        pulls_.resize(pull_begin_.back());
        std::vector<Index> next(pull_begin_.begin(), pull_begin_.end() - 1);
        for_each_pull([&](Index texel, Pull pull) { pulls_[next[texel]++] = pull; });
    }

    const TexelFit& fit_;
    std::vector<Index> number_;        // per texel, of those that move
    std::vector<std::size_t> texels_;  // that move
    std::vector<std::size_t> rows_;    // widths of their pages
    std::vector<std::pair<Ends, Ends>> pairs_;
    std::vector<Vec3f> differences_;  // per pair, of the vector that is multiplied
    std::vector<Index> pull_begin_;   // per texel, into pulls_
    std::vector<Pull> pulls_;
};

TexelFit::Values TexelFit::solve(const Values& start, const Context& context) const {
    System system(*this);
    const std::size_t size = system.size();
    // Jacobi's preconditioner.
    const std::vector<float> inverse = system.inverse_diagonal();
    Vector change(size), residual(size), search(size), product(size), scaled(size);
    const Vector wanted = misfit(start);
    for_all(size, context, [&](std::size_t i) { residual[i] = wanted[system.texel(i)]; });
    const auto rescale = [&] {
        for_all(size, context, [&](std::size_t i) { scaled[i] = residual[i] * inverse[i]; });
        return dot_all(residual, scaled, context);
    };
    double rho = rescale();
    const double enough = kPrecision * kPrecision * rho;
    search = scaled;
    for (int step = 0; step < kMaxSteps && rho > enough; ++step) {
        check_cancelled(context);
        system.multiply(search, product, context);
        const double curvature = dot_all(search, product, context);
        if (!(curvature > 0.0)) break;
        const auto along = static_cast<float>(rho / curvature);
        for_all(size, context, [&](std::size_t i) {
            change[i] += search[i] * along;
            residual[i] -= product[i] * along;
        });
        const double next = rescale();
        const auto turn = static_cast<float>(next / rho);
        rho = next;
        for_all(size, context, [&](std::size_t i) { search[i] = scaled[i] + search[i] * turn; });
    }
    Values out = start;
    std::size_t page = 0;
    for (std::size_t i = 0; i < size; ++i) {
        const std::size_t texel = system.texel(i);
        while (page + 1 < pages_.size() && texel >= first_of_page_[page + 1]) ++page;
        out[page][texel - first_of_page_[page]] += change[i];
    }
    return out;
}

}  // namespace pointbake
