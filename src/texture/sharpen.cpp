// A fixed-point iteration in the spirit of [Zwicker01]'s texture coefficients; the number of rounds
// comes from the data: on clean colours every round gains, on noisy ones each fits noise.
#include "texture/sharpen.h"

#include <algorithm>

#include "core/hash.h"
#include "core/parallel.h"

namespace pointbake {
namespace {

constexpr std::size_t kGrain = 64;       // triangles per chunk
constexpr int kMaxRounds = 6;            // more gain little at this kernel
constexpr std::uint64_t kLeaveOut = 10;  // one point in this many is left out to choose the rounds

// A place on the surface lies nearer to the points than one that was left out does, and farther
// than one that was kept: its error is guessed between theirs. By those left out alone, one round
// too few is chosen where points are evenly spaced.
constexpr double kKeptShare = 0.5;  // weight of the error at a kept item to that at one left out

struct SquaredError {
    double sum = 0.0;
    std::uint64_t count = 0;
    void add(Vec3f difference) {
        sum += static_cast<double>(squared_length(difference));
        ++count;
    }
    double mean() const { return count == 0 ? 0.0 : sum / static_cast<double>(count); }
};

struct RoundErrors {
    SquaredError left_out, kept;
    double guess() const { return left_out.mean() + kKeptShare * kept.mean(); }
};

// R as a sparse matrix: which splats reach each item that is not hidden, with what weights. Kept in
// the chunks that it was made in.
class Splatting {
 public:
    Splatting(const SplatScene& scene, const Context& context) : context_(context) {
        const std::size_t num_triangles = scene.mesh.triangles.size();
        chunks_.resize((num_triangles + kGrain - 1) / kGrain);
        parallel_for(context, num_triangles, kGrain, [&](std::size_t begin, std::size_t end) {
            LocalField field(scene);
            for (std::size_t t = begin; t < end; ++t)
                add_rows(scene, static_cast<Index>(t), field, chunks_[begin / kGrain]);
            chunks_[begin / kGrain].entries.shrink_to_fit();
        });
    }

    // visit(item, R(g) at the item, error) for all; `skip` (may be empty) leaves items out of the
    // sums: those of them that no other splat reaches are passed over. Returns the summed errors.
    template <class Visit>
    RoundErrors apply(const std::vector<Vec3f>& g, std::span<const std::uint8_t> skip,
                      Visit&& visit) const {
        const auto map = [&](std::size_t begin, std::size_t) {
            RoundErrors error;
            Index k = 0;
            for (const Row& row : chunks_[begin].rows) {
                Vec3f sum{};
                float weight = 0.0F;
                for (; k < row.end; ++k) {
                    const Entry& e = chunks_[begin].entries[k];
                    if (!skip.empty() && skip[e.item] != 0) continue;
                    sum += g[e.item] * e.weight;
                    weight += e.weight;
                }
                if (weight > 0.0F) visit(row.item, sum / weight, error);
            }
            return error;
        };
        const auto sum = [](SquaredError a, SquaredError b) {
            return SquaredError{a.sum + b.sum, a.count + b.count};
        };
        return parallel_reduce(context_, chunks_.size(), 1, RoundErrors{}, map,
                               [&](const RoundErrors& a, const RoundErrors& b) {
                                   return RoundErrors{sum(a.left_out, b.left_out),
                                                      sum(a.kept, b.kept)};
                               });
    }

 private:
    struct Entry {
        Index item;
        float weight;
    };
    struct Row {
        Index item, end;  // its entries end there and begin where those of the row before end
    };
    struct Chunk {
        std::vector<Row> rows;
        std::vector<Entry> entries;
    };

    static void add_rows(const SplatScene& scene, Index triangle, LocalField& field, Chunk& chunk) {
        const std::span<const Footprint> own = scene.prints.of(triangle);
        if (own.empty()) return;
        field.gather(triangle, 0.0);
        for (std::size_t k = 0; k < own.size(); ++k) {
            if (own[k].hidden) continue;
            field.for_each_weight(own[k].center, [&](Index item, float weight) {
                chunk.entries.push_back({item, weight});
            });
            chunk.rows.push_back({scene.prints.begin[triangle] + static_cast<Index>(k),
                                  static_cast<Index>(chunk.entries.size())});
        }
    }

    const Context& context_;
    std::vector<Chunk> chunks_;
};

// One round: next = g + (c - R(g)) for all items kept. Returns the errors of R(g).
RoundErrors round(const Splatting& splatting, MapKind kind, const std::vector<Vec3f>& c,
                  const std::vector<Vec3f>& g, std::span<const std::uint8_t> skip,
                  std::vector<Vec3f>& next) {
    return splatting.apply(g, skip, [&](Index item, Vec3f r, RoundErrors& errors) {
        const bool left_out = !skip.empty() && skip[item] != 0;
        (left_out ? errors.left_out : errors.kept).add(to_steps(kind, r) - to_steps(kind, c[item]));
        if (!left_out) next[item] = g[item] + (c[item] - r);
    });
}

// Rounds of sharpening that predict best, from the items kept.
int choose_rounds(const Splatting& splatting, MapKind kind, const std::vector<Vec3f>& c,
                  std::span<const std::uint64_t> rows) {
    std::vector<std::uint8_t> skip(c.size());
    for (std::size_t i = 0; i < skip.size(); ++i)
        skip[i] = hash64(rows[i]) % kLeaveOut == 0 ? 1 : 0;
    std::vector<Vec3f> g = c, next = c;
    int best = 0;
    double lowest = 0.0;
    for (int r = 0; r <= kMaxRounds; ++r) {
        const RoundErrors errors = round(splatting, kind, c, g, skip, next);
        if (errors.left_out.count == 0) return 0;
        if (r > 0 && errors.guess() >= lowest) break;
        best = r, lowest = errors.guess();
        g.swap(next);
    }
    return best;
}

}  // namespace

Sharpened sharpen(const SplatScene& scene, MapKind kind, std::vector<Vec3f> values,
                  std::span<const std::uint64_t> rows, const Context& context) {
    const Splatting splatting(scene, context);
    Sharpened out{values, values, choose_rounds(splatting, kind, values, rows)};
    std::vector<Vec3f> next = values;
    for (int r = 0; r < out.rounds; ++r) {
        round(splatting, kind, values, out.values, {}, next);
        out.values.swap(next);
    }
    splatting.apply(out.values, {},
                    [&](Index item, Vec3f r, RoundErrors&) { out.splatted[item] = r; });
    return out;
}

}  // namespace pointbake
