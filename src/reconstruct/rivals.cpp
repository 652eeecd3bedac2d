#include "reconstruct/rivals.h"

#include <algorithm>
#include <numeric>

#include "core/hash.h"
#include "core/parallel.h"
#include "core/parallel_sort.h"

namespace pointbake {
namespace {

constexpr std::size_t kGrain = 1024;

struct Ranked {
    std::uint64_t hash;
    Index point;
    friend bool operator<(const Ranked& a, const Ranked& b) {
        return a.hash != b.hash ? a.hash < b.hash : a.point < b.point;
    }
};

}  // namespace

Rivals gather_rivals(std::size_t num_points,
                     const std::function<void(Index, std::vector<Index>&)>& append,
                     const Context& context) {
    Rivals rivals;
    rivals.begin.assign(num_points + 1, 0);
    std::vector<std::vector<Index>> found_in((num_points + kGrain - 1) / kGrain);
    parallel_for(context, num_points, kGrain, [&](std::size_t begin, std::size_t end) {
        std::vector<Index>& found = found_in[begin / kGrain];
        for (std::size_t i = begin; i < end; ++i) {
            const std::size_t before = found.size();
            append(static_cast<Index>(i), found);
            rivals.begin[i + 1] = found.size() - before;
        }
    });
    std::partial_sum(rivals.begin.begin(), rivals.begin.end(), rivals.begin.begin());
    rivals.list.reserve(rivals.begin.back());
    for (const auto& part : found_in)
        rivals.list.insert(rivals.list.end(), part.begin(), part.end());
    return rivals;
}

std::vector<std::uint8_t> choose_among_rivals(std::span<const Vec3d> points, const Rivals& rivals,
                                              const Context& context) {
    std::vector<Ranked> order;
    for (Index i = 0; i < points.size(); ++i)
        if (!rivals.of(i).empty()) order.push_back({hash_of(points[i]), i});
    parallel_sort(context, order);
    std::vector<std::uint8_t> is_kept(points.size(), 1);
    for (const Ranked& r : order) is_kept[r.point] = 0;
    for (const Ranked& r : order) {
        const auto others = rivals.of(r.point);
        is_kept[r.point] =
            std::none_of(others.begin(), others.end(), [&](Index j) { return is_kept[j] != 0; });
    }
    return is_kept;
}

}  // namespace pointbake
