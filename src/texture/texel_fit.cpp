#include "texture/texel_fit.h"

#include <cmath>

#include "core/parallel.h"

namespace pointbake {
namespace {

constexpr std::size_t kRowGrain = 16;
constexpr int kMaxSteps = 40;
constexpr double kPrecision = 1e-4;  // residual over that of the start

using Values = TexelFit::Values;

Values zeros_like(const Values& values) {
    Values out;
    for (const std::vector<Vec3f>& page : values) out.emplace_back(page.size());
    return out;
}

double dot_all(const Values& a, const Values& b, const Context& context) {
    double sum = 0.0;
    for (std::size_t p = 0; p < a.size(); ++p) {
        constexpr std::size_t kGrain = 1 << 14;
        sum += parallel_reduce(
            context, a[p].size(), kGrain, 0.0,
            [&](std::size_t begin, std::size_t end) {
                double part = 0.0;
                for (std::size_t i = begin; i < end; ++i)
                    part += static_cast<double>(dot(a[p][i], b[p][i]));
                return part;
            },
            std::plus<>());
    }
    return sum;
}

template <class Update>
void for_all(const Values& values, const Context& context, Update&& update) {
    constexpr std::size_t kGrain = 1 << 14;
    for (std::size_t p = 0; p < values.size(); ++p)
        parallel_for(context, values[p].size(), kGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) update(p, i);
        });
}

}  // namespace

TexelFit::TexelFit(std::span<const PageSize> pages, const Values& start)
    : pages_(pages.begin(), pages.end()), start_(start), right_(zeros_like(start)) {
    for (const std::vector<Vec3f>& page : start) {
        matrix_.emplace_back(page.size());
        prior_.emplace_back(page.size());
    }
}

std::optional<TexelFit::Tap> TexelFit::tap(Index page, Vec2d texel) const {
    const double x0 = std::floor(texel.x), y0 = std::floor(texel.y);
    const PageSize size = pages_[page];
    if (!(x0 >= 0.0 && y0 >= 0.0 && x0 + 1.0 < size.width && y0 + 1.0 < size.height))
        return std::nullopt;
    const auto fx = static_cast<float>(texel.x - x0), fy = static_cast<float>(texel.y - y0);
    const std::size_t first = static_cast<std::size_t>(y0) * static_cast<std::size_t>(size.width) +
                              static_cast<std::size_t>(x0);
    return Tap{
        page, first, {(1.0F - fx) * (1.0F - fy), fx * (1.0F - fy), (1.0F - fx) * fy, fx * fy}};
}

Vec3f TexelFit::read(const Values& values, const Tap& tap) const {
    const std::vector<Vec3f>& v = values[tap.page];
    const auto w = static_cast<std::size_t>(pages_[tap.page].width);
    return v[tap.first] * tap.weights[0] + v[tap.first + 1] * tap.weights[1] +
           v[tap.first + w] * tap.weights[2] + v[tap.first + w + 1] * tap.weights[3];
}

void TexelFit::scatter(const Tap& tap, Vec3f value, Values& to) const {
    std::vector<Vec3f>& v = to[tap.page];
    const auto w = static_cast<std::size_t>(pages_[tap.page].width);
    v[tap.first] += value * tap.weights[0];
    v[tap.first + 1] += value * tap.weights[1];
    v[tap.first + w] += value * tap.weights[2];
    v[tap.first + w + 1] += value * tap.weights[3];
}

void TexelFit::add_sample(const Tap& tap, Vec3f wanted, float weight) {
    scatter(tap, (wanted - read(start_, tap)) * weight, right_);
    std::vector<Stencil>& m = matrix_[tap.page];
    const std::size_t i = tap.first, below = i + static_cast<std::size_t>(pages_[tap.page].width);
    const auto [a, b, c, d] = tap.weights;
    m[i].self += weight * a * a;
    m[i + 1].self += weight * b * b;
    m[below].self += weight * c * c;
    m[below + 1].self += weight * d * d;
    m[i].right += weight * a * b;
    m[below].right += weight * c * d;
    m[i].lower += weight * a * c;
    m[i + 1].lower += weight * b * d;
    m[i].lower_right += weight * a * d;
    m[i + 1].lower_left += weight * b * c;
}

void TexelFit::add_pair(const Tap& a, const Tap& b, float weight) {
    const Vec3f difference = (read(start_, b) - read(start_, a)) * weight;
    scatter(a, difference, right_);
    scatter(b, difference * -1.0F, right_);
    pairs_.push_back({a, b, weight});
}

void TexelFit::add_prior(Index page, std::size_t texel, float weight) {
    prior_[page][texel] += weight;
}

void TexelFit::multiply(const Values& x, Values& out, const Context& context) const {
    for (std::size_t p = 0; p < pages_.size(); ++p) {
        const auto w = static_cast<std::size_t>(pages_[p].width),
                   h = static_cast<std::size_t>(pages_[p].height);
        const std::vector<Stencil>& m = matrix_[p];
        const std::vector<Vec3f>& v = x[p];
        parallel_for(context, h, kRowGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t row = begin; row < end; ++row)
                for (std::size_t column = 0; column < w; ++column) {
                    const std::size_t i = row * w + column;
                    Vec3f sum = v[i] * (m[i].self + prior_[p][i]);
                    if (m[i].self > 0.0F) {
                        if (column + 1 < w) sum += v[i + 1] * m[i].right;
                        if (column > 0) sum += v[i - 1] * m[i - 1].right;
                        if (row + 1 < h) {
                            sum += v[i + w] * m[i].lower;
                            if (column > 0) sum += v[i + w - 1] * m[i].lower_left;
                            if (column + 1 < w) sum += v[i + w + 1] * m[i].lower_right;
                        }
                        if (row > 0) {
                            sum += v[i - w] * m[i - w].lower;
                            if (column + 1 < w) sum += v[i - w + 1] * m[i - w + 1].lower_left;
                            if (column > 0) sum += v[i - w - 1] * m[i - w - 1].lower_right;
                        }
                    }
                    out[p][i] = sum;
                }
        });
    }
    for (const Pair& pair : pairs_) {
        const Vec3f difference = (read(x, pair.a) - read(x, pair.b)) * pair.weight;
        scatter(pair.a, difference, out);
        scatter(pair.b, difference * -1.0F, out);
    }
}

TexelFit::Values TexelFit::solve(const Context& context) const {
    // Jacobi's preconditioner; texels without a prior have no say.
    std::vector<std::vector<float>> inverse(pages_.size());
    std::vector<std::vector<float>> diagonal;
    for (std::size_t p = 0; p < pages_.size(); ++p) {
        diagonal.emplace_back(prior_[p]);
        for (std::size_t i = 0; i < diagonal[p].size(); ++i) diagonal[p][i] += matrix_[p][i].self;
    }
    for (const Pair& pair : pairs_)
        for (const Tap& tap : {pair.a, pair.b}) {
            const auto w = static_cast<std::size_t>(pages_[tap.page].width);
            const std::array<std::size_t, 4> at{0, 1, w, w + 1};
            for (std::size_t k = 0; k < 4; ++k)
                diagonal[tap.page][tap.first + at[k]] +=
                    pair.weight * tap.weights[k] * tap.weights[k];
        }
    for (std::size_t p = 0; p < pages_.size(); ++p)
        for (std::size_t i = 0; i < diagonal[p].size(); ++i)
            inverse[p].push_back(prior_[p][i] > 0.0F ? 1.0F / diagonal[p][i] : 0.0F);

    Values change = zeros_like(start_), residual = right_, search = zeros_like(start_),
           product = zeros_like(start_), scaled = zeros_like(start_);
    const auto rescale = [&] {
        for_all(residual, context, [&](std::size_t p, std::size_t i) {
            scaled[p][i] = residual[p][i] * inverse[p][i];
        });
        return dot_all(residual, scaled, context);
    };
    double rho = rescale();
    const double enough = kPrecision * kPrecision * rho;
    search = scaled;
    for (int step = 0; step < kMaxSteps && rho > enough; ++step) {
        check_cancelled(context);
        multiply(search, product, context);
        const double curvature = dot_all(search, product, context);
        if (!(curvature > 0.0)) break;
        const auto along = static_cast<float>(rho / curvature);
        for_all(change, context, [&](std::size_t p, std::size_t i) {
            change[p][i] += search[p][i] * along;
            residual[p][i] -= product[p][i] * along;
        });
        const double next = rescale();
        const auto turn = static_cast<float>(next / rho);
        rho = next;
        for_all(search, context, [&](std::size_t p, std::size_t i) {
            search[p][i] = scaled[p][i] + search[p][i] * turn;
        });
    }
    for_all(change, context, [&](std::size_t p, std::size_t i) { change[p][i] += start_[p][i]; });
    return change;
}

}  // namespace pointbake
