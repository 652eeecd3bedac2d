#include "reconstruct/rivals.h"

#include <algorithm>

#include "core/hash.h"
#include "core/parallel_sort.h"

namespace pointbake {
namespace {

struct Ranked {
    std::uint64_t hash;
    Index point;
    friend bool operator<(const Ranked& a, const Ranked& b) {
        return a.hash != b.hash ? a.hash < b.hash : a.point < b.point;
    }
};

}  // namespace

std::vector<std::uint8_t> choose_among_rivals(std::span<const Vec3d> points,
                                              const RivalsOf& rivals_of, const Context& context) {
    std::vector<Ranked> order;
    std::size_t count = 0;
    for (Index i = 0; i < points.size(); ++i) count += rivals_of(i).empty() ? 0 : 1;
    order.reserve(count);
    for (Index i = 0; i < points.size(); ++i)
        if (!rivals_of(i).empty()) order.push_back({hash_of(points[i]), i});
    parallel_sort(context, order);
    std::vector<std::uint8_t> is_kept(points.size(), 1);
    for (const Ranked& r : order) is_kept[r.point] = 0;
    for (const Ranked& r : order) {
        const auto others = rivals_of(r.point);
        is_kept[r.point] =
            std::none_of(others.begin(), others.end(), [&](Index j) { return is_kept[j] != 0; });
    }
    return is_kept;
}

}  // namespace pointbake
