// Texels whose bilinear reading comes nearest to what is wanted at many places at once: regularised
// least squares instead of samples at their centres.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "pointbake/context.h"
#include "pointbake/patch.h"
#include "pointbake/types.h"

namespace pointbake {

/// Minimises sum w |B t - c|^2 + sum p |t - t0|^2 + sum w |A t - B t|^2 over the texels t of some
/// pages, by conjugate gradients from t0: samples, a prior, and pairs of places that should show
/// the same. Linear in texels, samples and pairs.
class TexelFit {
 public:
    /// Values of the texels by page and rows: t0.
    using Values = std::vector<std::vector<Vec3f>>;

    explicit TexelFit(std::span<const PageSize> pages);

    /// The four texels that are read at a place, integers being centres.
    struct Tap {
        Index page = 0;
        std::size_t first = 0;  // of the four, upper left, in its page
        std::array<float, 4> weights{};
    };
    /// std::nullopt beyond the centres of the page's outermost texels.
    std::optional<Tap> tap(Index page, Vec2d texel) const;

    void add_sample(const Tap& tap, Vec3f wanted, float weight);
    void add_pair(const Tap& a, const Tap& b, float weight);
    /// Texels without a prior stay as they are.
    void add_prior(Index page, std::size_t texel, float weight);

    /// What comes nearest, from t0 on.
    Values solve(const Values& start, const Context& context) const;

 private:
    /// Of the symmetric matrix: a texel with itself and with four of the eight around it; the
    /// others have the rest.
    struct Stencil {
        float self = 0.0F, right = 0.0F, lower_left = 0.0F, lower = 0.0F, lower_right = 0.0F;
    };
    struct Pair {
        Tap a, b;
        float weight;
    };
    class System;
    std::array<std::size_t, 4> texels_of(const Tap& tap) const;
    std::vector<Vec3f> misfit(const Values& start) const;
    void scatter(const Tap& tap, Vec3f value, std::vector<Vec3f>& to) const;

    std::vector<PageSize> pages_;
    std::vector<std::size_t> first_of_page_;  // texels of all pages, one after the other
    std::vector<Stencil> matrix_;             // per texel
    std::vector<float> prior_;
    std::vector<Vec3f> right_;  // what the samples ask for
    std::vector<Pair> pairs_;
};

}  // namespace pointbake
