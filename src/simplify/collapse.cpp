// Quadric edge collapse [Garland97]. While triangles abound, edges go in sweeps over the vertices,
// each with a threshold on the cost: neighbours in memory are neighbours in space, and blocks of
// vertices are worked on in parallel. The last few halvings go strictly by cost.
#include "simplify/collapse.h"

#include <algorithm>
#include <array>

#include "core/message.h"
#include "core/parallel.h"
#include "simplify/indexed_heap.h"
#include "simplify/legality.h"
#include "simplify/ordering.h"

namespace pointbake {
namespace {

constexpr std::size_t kVertexGrain = 2048;
constexpr std::uint64_t kEdgesPerPoll = 1024;
// Sweeps end at this many times the wanted number of triangles: below, the order matters.
constexpr double kSweepEnd = 3.0;
// A sweep takes the cheapest of the vertices' best edges, this share of them.
constexpr double kSweepShare = 0.4;
// Sweeps end when this share of their collapses is refused by the bound, or when they collapse less
// than this share of the vertices.
constexpr double kMaxRefusedShare = 0.1;
constexpr double kMinSweepGain = 0.02;
// Living vertices of a block; an edge is taken if its rings lie within one.
constexpr std::size_t kBlockSize = 8192;

// What an edge is tried as, one after the other: a collapse by all rules, one that may make
// needles, one that may turn triangles over, and the removal of the whole part, if it is tiny. A
// collapse is the dearer the fewer rules it keeps, so that a rule gives way where keeping it would
// cost far more elsewhere; a removal has its own price. Under a bound all rules hold.
constexpr std::array kPenalties{1.0F, 16.0F, 256.0F, 1.0F};
constexpr std::size_t kRemoval = kPenalties.size() - 1;
// Parts of more triangles are never removed.
constexpr std::size_t kLargestPart = 64;
// Error of leaving a part out, per squared area: as if it lay a quarter of its size off the rest.
constexpr double kRemovalError = 0.06;

// An edge as seen from its lower vertex.
struct Candidate {
    float cost = HUGE_VALF;
    Index other = kInvalidIndex;
    friend bool operator<(const Candidate& x, const Candidate& y) {
        return x.cost != y.cost ? x.cost < y.cost : x.other < y.other;
    }
};
// An edge at the price of what it is to be tried as.
struct Attempt {
    Candidate edge;
    std::uint8_t kind = 0;  // into kPenalties
};
// Below every candidate.
constexpr Candidate kNothingRefused{-1.0F, 0};
using Refusals = std::array<Candidate, kPenalties.size()>;
constexpr Refusals kNoRefusals{kNothingRefused, kNothingRefused, kNothingRefused, kNothingRefused};

class Collapser {
 public:
    Collapser(Surface& surface, Attribution& attribution, const CollapseLimits& limits,
              const Context& context)
        : surface_(surface),
          attribution_(attribution),
          limits_(limits),
          context_(context),
          order_(surface, context),
          marks_(surface.positions.size(), 0),
          trace_(surface),
          judge_(surface, attribution, trace_, marks_, limits.squared_distance),
          best_(surface.positions.size()),
          refused_(surface.positions.size(), kNoRefusals),
          removal_costs_(surface.positions.size(), 0.0F),
          changed_(surface.positions.size(), 1),
          heap_(surface.positions.size()),
          is_in_part_(surface.positions.size(), 0),
          num_before_(surface.num_triangles) {}

    CollapseCounts run() {
        sweep_while_many();
        std::fill(changed_.begin(), changed_.end(), std::uint8_t{1});
        num_attempts_ = is_bounded() ? 1 : kPenalties.size();
        pass_until_stuck();
        return counts_;
    }

 private:
    bool is_done() const { return surface_.num_triangles <= limits_.num_triangles; }
    bool is_bounded() const { return limits_.squared_distance < HUGE_VAL; }
    void report() const {
        const double goal = std::max<double>(1.0, num_before_ - limits_.num_triangles);
        const double done = (num_before_ - surface_.num_triangles) / goal;
        report_progress(
            context_, "simplify",
            limits_.progress_begin + (limits_.progress_end - limits_.progress_begin) * done);
    }

    Attempt next_attempt(Index v, Index w) const;
    Attempt best_edge(Index v) const;

    void forget_refusals(Index v);

    void sweep_while_many();
    CollapseCounts sweep(std::size_t offset);
    void sweep_block(Index begin, Index end, float threshold, CollapseCounts& counts);
    bool is_within(Index v, Index begin, Index end) const;
    float sweep_threshold(const std::vector<Index>& alive) const;

    void pass_until_stuck();
    void enqueue(Index v, Attempt best);
    void fill_queue();
    void drain_queue();
    bool try_collapse(Index a);
    bool try_removal(Index a);
    void update_queue(Index a, Index b);

    Surface& surface_;
    Attribution& attribution_;
    CollapseLimits limits_;
    const Context& context_;
    CollapseOrder order_;
    std::vector<std::uint8_t> marks_;
    BorderTrace trace_;
    CollapseJudge judge_;
    std::vector<Attempt> best_;         // per vertex
    std::vector<Refusals> refused_;     // per vertex and attempt: edges up to this were refused
    std::vector<float> removal_costs_;  // per vertex, if known to be above the edge's
    std::size_t num_attempts_ = 1;
    std::vector<std::uint8_t> changed_;  // ring changed since best_ was found
    IndexedHeap heap_;
    std::vector<EdgeUse> edges_;
    std::vector<Index> part_;
    std::vector<std::uint8_t> is_in_part_;
    Index num_before_;
    CollapseCounts counts_;
};

void count(Verdict verdict, CollapseCounts& counts) {
    counts.num_collapses += verdict == Verdict::kLegal ? 1 : 0;
    counts.num_rejected_by_topology += verdict == Verdict::kTopology ? 1 : 0;
    counts.num_rejected_by_shape += verdict == Verdict::kShape ? 1 : 0;
    counts.num_rejected_by_bound += verdict == Verdict::kBound ? 1 : 0;
}

CollapseCounts sum(CollapseCounts a, const CollapseCounts& b) {
    a.num_collapses += b.num_collapses;
    a.num_rejected_by_bound += b.num_rejected_by_bound;
    a.num_rejected_by_topology += b.num_rejected_by_topology;
    a.num_rejected_by_shape += b.num_rejected_by_shape;
    a.num_triangles_removed += b.num_triangles_removed;
    return a;
}

// The edge at the price of the first kind of attempt that was not refused to it.
Attempt Collapser::next_attempt(Index v, Index w) const {
    Attempt a{{order_.cost(v, w), w}};
    while (a.kind < num_attempts_ && !(refused_[v][a.kind] < a.edge)) ++a.kind;
    if (a.kind == num_attempts_) return {};
    a.edge.cost *= kPenalties[a.kind];
    if (a.kind == kRemoval) a.edge.cost = std::max(a.edge.cost, removal_costs_[v]);
    return a;
}

// The cheapest edge to a higher vertex: each edge waits at its lower one.
Attempt Collapser::best_edge(Index v) const {
    Attempt best;
    const auto offer = [&](Index w) {
        if (w < v || !order_.is_movable(v, w)) return;
        const Attempt a = next_attempt(v, w);
        if (a.edge < best.edge) best = a;
    };
    // Around an interior vertex every neighbour comes after it once.
    const bool is_interior = surface_.kinds[v] == VertexKind::kInterior;
    surface_.for_each_corner(v, [&](Index c) {
        offer(surface_.after(c));
        if (!is_interior) offer(surface_.before(c));
    });
    return best;
}

void Collapser::forget_refusals(Index v) {
    refused_[v] = kNoRefusals;
    removal_costs_[v] = 0.0F;
}

void Collapser::sweep_while_many() {
    const double end = kSweepEnd * limits_.num_triangles;
    for (std::size_t round = 0; surface_.num_triangles > end; ++round) {
        const Index num_before = surface_.num_triangles;
        const CollapseCounts counts = sweep(round % 2 == 0 ? kBlockSize : kBlockSize / 2);
        surface_.num_triangles -= static_cast<Index>(counts.num_triangles_removed);
        counts_ = sum(counts_, counts);
        report();
        const auto refused = static_cast<double>(counts.num_rejected_by_bound);
        if (refused > kMaxRefusedShare * static_cast<double>(counts.num_collapses)) break;
        if (num_before - surface_.num_triangles < kMinSweepGain * num_before) break;
    }
}

// The cost up to which a share of the vertices has an edge.
float Collapser::sweep_threshold(const std::vector<Index>& alive) const {
    std::vector<float> costs;
    for (Index v : alive) {
        if (best_[v].edge.other != kInvalidIndex) costs.push_back(best_[v].edge.cost);
    }
    if (costs.empty()) return 0.0F;
    const auto rank = static_cast<std::ptrdiff_t>(kSweepShare * static_cast<double>(costs.size()));
    std::nth_element(costs.begin(), costs.begin() + rank, costs.end());
    return costs[static_cast<std::size_t>(rank)];
}

// Blocks are ranges of vertices with `offset` living ones in the first, kBlockSize in the others.
// The offset changes from sweep to sweep, so that the blocks' borders get their turn.
CollapseCounts Collapser::sweep(std::size_t offset) {
    std::vector<Index> alive;
    for (Index v = 0; v < surface_.positions.size(); ++v) {
        if (surface_.first_corners[v] != kInvalidIndex) alive.push_back(v);
    }
    parallel_for(context_, alive.size(), kVertexGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (!changed_[alive[i]]) continue;
            best_[alive[i]] = best_edge(alive[i]);
            changed_[alive[i]] = 0;
        }
    });
    const float threshold = sweep_threshold(alive);
    const auto first_of = [&](std::size_t block) {
        const std::size_t i = block == 0 ? 0 : (block - 1) * kBlockSize + offset;
        return i < alive.size() ? alive[i] : static_cast<Index>(surface_.positions.size());
    };
    return parallel_reduce(
        context_, alive.size() / kBlockSize + 2, 1, CollapseCounts{},
        [&](std::size_t block, std::size_t) {
            CollapseCounts counts;
            sweep_block(first_of(block), first_of(block + 1), threshold, counts);
            return counts;
        },
        sum);
}

bool Collapser::is_within(Index v, Index begin, Index end) const {
    for (Index c = surface_.first_corners[v]; c != kInvalidIndex; c = surface_.next_corners[c]) {
        for (Index w : surface_.triangles[c / 3]) {
            if (w < begin || w >= end) return false;
        }
    }
    return true;
}

void Collapser::sweep_block(Index begin, Index end, float threshold, CollapseCounts& counts) {
    CollapseJudge judge(surface_, attribution_, trace_, marks_, limits_.squared_distance);
    for (Index v = begin; v < end; ++v) {
        if (surface_.first_corners[v] == kInvalidIndex) continue;
        Candidate best = best_[v].edge;
        if (!changed_[v] && best.cost > threshold) continue;
        if (!is_within(v, begin, end)) continue;
        if (changed_[v]) best = best_edge(v).edge;
        if (best.cost > threshold || best.other == kInvalidIndex ||
            !is_within(best.other, begin, end))
            continue;
        const Index a = v, b = best.other;
        const Vec3d target = order_.placement(a, b);
        const Verdict verdict = judge.judge(a, b, target);
        count(verdict, counts);
        if (verdict != Verdict::kLegal) {
            refused_[v][0] = best;
            changed_[v] = 1;
            continue;
        }
        counts.num_triangles_removed += judge.apply(a, b, target);
        order_.merge(a, b);
        forget_refusals(a);
        best_[b] = {};
        surface_.for_each_corner(a, [&](Index c) {
            for (Index w : surface_.triangles[c / 3]) {
                changed_[w] = 1;
                forget_refusals(w);
            }
        });
    }
}

// Collapses until nothing legal is left. An edge that was refused is tried again once its ring has
// changed.
void Collapser::pass_until_stuck() {
    std::uint64_t before = 0;
    do {
        before = counts_.num_collapses;
        fill_queue();
        drain_queue();
    } while (!is_done() && counts_.num_collapses > before);
}

void Collapser::enqueue(Index v, Attempt best) {
    best_[v] = best;
    if (best.edge.other == kInvalidIndex)
        heap_.remove(v);
    else
        heap_.set(v, best.edge.cost);
}

// Takes up all vertices around which something changed.
void Collapser::fill_queue() {
    const std::size_t n = surface_.positions.size();
    std::vector<std::uint8_t> is_due(n, 0);
    parallel_for(context_, n, kVertexGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const Index v = static_cast<Index>(i);
            if (surface_.first_corners[v] == kInvalidIndex) continue;
            surface_.for_each_corner(v, [&](Index c) {
                for (Index w : surface_.triangles[c / 3]) {
                    if (changed_[w]) is_due[v] = 1;
                }
            });
            if (!is_due[v]) continue;
            forget_refusals(v);
            best_[v] = best_edge(v);
        }
    });
    for (Index v = 0; v < n; ++v) {
        if (is_due[v]) enqueue(v, best_[v]);
    }
    std::fill(changed_.begin(), changed_.end(), std::uint8_t{0});
}

void Collapser::drain_queue() {
    std::uint64_t num_popped = 0;
    while (!heap_.empty() && !is_done()) {
        if (++num_popped % kEdgesPerPoll == 0) {
            check_cancelled(context_);
            report();
        }
        const Index a = heap_.top().id;
        const bool is_over = best_[a].kind == kRemoval ? try_removal(a) : try_collapse(a);
        if (!is_over) enqueue(a, best_edge(a));
    }
}

// False if the edge was refused.
bool Collapser::try_collapse(Index a) {
    constexpr std::array kStrictness{Strictness::kFull, Strictness::kShapeFree,
                                     Strictness::kTopologyOnly};
    const Index b = best_[a].edge.other;
    const std::size_t kind = best_[a].kind;
    judge_.strictness = kStrictness[kind];
    Vec3d target = order_.placement(a, b);
    Verdict verdict = judge_.judge(a, b, target);
    // Where the best place is refused, one of the vertices may stay where it is. It costs more
    // than the queue knew: only for a bound, where the number of triangles is what counts.
    for (Index v : {a, b}) {
        if (verdict == Verdict::kLegal || verdict == Verdict::kTopology || !is_bounded() ||
            surface_.kinds[a] != surface_.kinds[b])
            break;
        target = surface_.positions[v];
        verdict = judge_.judge(a, b, target);
    }
    count(verdict, counts_);
    if (verdict != Verdict::kLegal) {
        refused_[a][kind] = {order_.cost(a, b), b};
        return false;
    }
    surface_.num_triangles -= judge_.apply(a, b, target);
    order_.merge(a, b);
    update_queue(a, b);
    return true;
}

// Removes the part that hangs together with vertex a if it is tiny and its turn has come.
bool Collapser::try_removal(Index a) {
    part_.assign(1, a);
    is_in_part_[a] = 1;
    double area = 0.0;
    std::size_t num_corners = 0;
    for (std::size_t head = 0; head < part_.size() && num_corners <= 3 * kLargestPart; ++head) {
        surface_.for_each_corner(part_[head], [&](Index c) {
            ++num_corners;
            area += triangle_area(surface_, c / 3) / 3.0;
            for (Index w : surface_.triangles[c / 3]) {
                if (is_in_part_[w] != 0) continue;
                is_in_part_[w] = 1;
                part_.push_back(w);
            }
        });
    }
    for (Index v : part_) is_in_part_[v] = 0;
    const Candidate tried = best_[a].edge;
    const auto cost = static_cast<float>(kRemovalError * area * area);
    if (num_corners > 3 * kLargestPart || surface_.num_triangles * 3 <= num_corners) {
        refused_[a][kRemoval] = {order_.cost(a, tried.other), tried.other};
        return false;
    }
    if (cost > tried.cost) {
        removal_costs_[a] = cost;
        return false;
    }
    for (Index v : part_) {
        while (surface_.first_corners[v] != kInvalidIndex) {
            const Index t = surface_.first_corners[v] / 3;
            attribution_.first_points[t] = kInvalidIndex;
            surface_.remove(t);
        }
        enqueue(v, {});
    }
    ++counts_.num_parts_removed;
    return true;
}

// Vertex b became a: edges at a have new costs, edges at b are gone.
void Collapser::update_queue(Index a, Index b) {
    enqueue(b, {});
    forget_refusals(a);
    changed_[a] = 1;
    collect_edges(surface_, a, edges_);
    for (const EdgeUse& e : edges_) {
        const Index n = e.neighbor;
        changed_[n] = 1;
        const Candidate c{n < a ? order_.cost(n, a) : HUGE_VALF, a};
        // Edges refused above the new one get a second chance with it.
        if (n < a && !(refused_[n][0] < c)) forget_refusals(n);
        if (best_[n].edge.other == a || best_[n].edge.other == b)
            enqueue(n, best_edge(n));
        else if (c < best_[n].edge)
            enqueue(n, {c});
    }
    enqueue(a, best_edge(a));
}

}  // namespace

CollapseCounts collapse_edges_in_place(Surface& surface, Attribution& attribution,
                                       const CollapseLimits& limits, const Context& context) {
    return Collapser(surface, attribution, limits, context).run();
}

}  // namespace pointbake
