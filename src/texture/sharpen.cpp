// A fixed-point iteration in the spirit of [Zwicker01]'s texture coefficients; the number of rounds
// comes from the data: on clean colours every round gains, on noisy ones each fits noise.
#include "texture/sharpen.h"

#include <algorithm>

#include "core/hash.h"
#include "core/parallel.h"

namespace pointbake {
namespace {

constexpr std::size_t kGrain = 64;       // triangles per chunk
constexpr int kMaxRounds = 4;            // further rounds gain nothing measurable
constexpr std::uint64_t kLeaveOut = 10;  // one point in this many is left out to choose the rounds
constexpr float kMinGain =
    0.998F;  // an additional round must lower the prediction error to this share

struct SquaredError {
    double sum = 0.0;
    std::uint64_t count = 0;
};

Vec3f value_or(const SplatSum& s, Vec3f otherwise) {
    return s.weight > 0.0F ? s.sum / s.weight : otherwise;
}

// One round: next = g + (c - R(g)) for all items kept. Returns the error of R(g) at the items left
// out.
SquaredError round(const SplatScene& scene, MapKind kind, const std::vector<Vec3f>& c,
                   const std::vector<Vec3f>& g, std::span<const std::uint8_t> skip,
                   std::vector<Vec3f>& next, const Context& context) {
    const auto map = [&](std::size_t begin, std::size_t end) {
        LocalField field(scene);
        SquaredError error;
        for (std::size_t t = begin; t < end; ++t) {
            const auto triangle = static_cast<Index>(t);
            const std::span<const Footprint> own = scene.prints.of(triangle);
            if (own.empty()) continue;
            field.gather(triangle, 0.0);
            for (std::size_t k = 0; k < own.size(); ++k) {
                const std::size_t item = scene.prints.begin[triangle] + k;
                if (own[k].hidden) continue;
                const Vec3f r = value_or(field.evaluate(own[k].center, g, skip), c[item]);
                if (!skip.empty() && skip[item]) {
                    const Vec3f d = to_steps(kind, r) - to_steps(kind, c[item]);
                    error.sum += static_cast<double>(squared_length(d));
                    ++error.count;
                } else {
                    next[item] = g[item] + (c[item] - r);
                }
            }
        }
        return error;
    };
    return parallel_reduce(context, scene.mesh.triangles.size(), kGrain, SquaredError{}, map,
                           [](SquaredError a, SquaredError b) {
                               return SquaredError{a.sum + b.sum, a.count + b.count};
                           });
}

// Rounds of sharpening that predict the left-out items best.
int choose_rounds(const SplatScene& scene, MapKind kind, const std::vector<Vec3f>& c,
                  std::span<const std::uint64_t> rows, const Context& context) {
    std::vector<std::uint8_t> skip(c.size());
    for (std::size_t i = 0; i < skip.size(); ++i)
        skip[i] = hash64(rows[i]) % kLeaveOut == 0 ? 1 : 0;
    std::vector<Vec3f> g = c, next = c;
    int best = 0;
    double lowest = 0.0;
    for (int r = 0; r <= kMaxRounds; ++r) {
        const SquaredError error = round(scene, kind, c, g, skip, next, context);
        if (error.count == 0) return 0;
        const double mean = error.sum / static_cast<double>(error.count);
        if (r > 0 && !(mean < lowest * static_cast<double>(kMinGain))) break;
        best = r, lowest = mean;
        g.swap(next);
    }
    return best;
}

}  // namespace

Sharpened sharpen(const SplatScene& scene, MapKind kind, std::vector<Vec3f> values,
                  std::span<const std::uint64_t> rows, const Context& context) {
    Sharpened out{values, choose_rounds(scene, kind, values, rows, context)};
    std::vector<Vec3f> next = values;
    for (int r = 0; r < out.rounds; ++r) {
        round(scene, kind, values, out.values, {}, next, context);
        out.values.swap(next);
    }
    return out;
}

}  // namespace pointbake
