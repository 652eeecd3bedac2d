#include "reconstruct/ears.h"

#include <algorithm>
#include <queue>

namespace pointbake {
namespace {

// An ear goes on within 60 degrees of what lies behind both its edges.
constexpr double kLeastCos = 0.5;

class Cutter {
 public:
    Cutter(std::span<const Vec3d> points, const std::function<bool(Index, Index)>& is_edge,
           const Loop& loop)
        : points_(points),
          is_edge_(is_edge),
          loop_(loop),
          normals_(loop.normals),
          next_(loop.vertices.size()),
          before_(next_.size()),
          is_left_(next_.size(), 1) {
        const std::size_t n = next_.size();
        for (std::size_t i = 0; i < n; ++i) next_[i] = (i + 1) % n, before_[i] = (i + n - 1) % n;
        for (std::size_t i = 0; i < n; ++i) offer(i);
    }

    bool cut(std::size_t num_left, std::vector<Triangle>& ears) {
        for (std::size_t n = next_.size(); n > num_left;) {
            if (offers_.empty()) return false;
            const Offer best = offers_.top();
            offers_.pop();
            const std::size_t i = best.tip, a = before_[i], b = next_[i];
            if (is_left_[i] == 0 || a != best.from || b != best.to || !is_ear(a, i, b)) continue;
            ears.push_back({loop_.vertices[a], loop_.vertices[i], loop_.vertices[b]});
            normals_[a] = normal(a, i, b);
            is_left_[i] = 0, next_[a] = b, before_[b] = a;
            offer(a), offer(b);
            --n;
        }
        return true;
    }

    Loop rest() const {
        Loop out{{}, {}, loop_.piece_area};
        for (std::size_t i = 0; i < next_.size(); ++i) {
            if (is_left_[i] == 0) continue;
            out.vertices.push_back(loop_.vertices[i]);
            out.normals.push_back(normals_[i]);
        }
        return out;
    }

 private:
    struct Offer {
        double chord2;
        std::size_t tip, from, to;
        friend bool operator<(const Offer& x, const Offer& y) {
            return x.chord2 != y.chord2 ? x.chord2 > y.chord2 : x.tip > y.tip;
        }
    };

    Vec3d point(std::size_t i) const { return points_[loop_.vertices[i]]; }
    Vec3d normal(std::size_t a, std::size_t i, std::size_t b) const {
        return cross(point(i) - point(a), point(b) - point(a));
    }

    void offer(std::size_t i) {
        offers_.push(
            {squared_length(point(next_[i]) - point(before_[i])), i, before_[i], next_[i]});
    }

    bool is_ear(std::size_t a, std::size_t i, std::size_t b) const {
        const Vec3d own = normal(a, i, b);
        const auto goes_on = [&](Vec3d behind) {
            return dot(own, behind) >
                   kLeastCos * std::sqrt(squared_length(own) * squared_length(behind));
        };
        if (!goes_on(normals_[a]) || !goes_on(normals_[i])) return false;
        return !is_edge_(loop_.vertices[a], loop_.vertices[b]) && is_empty(a, i, b, own);
    }

    // No other vertex above or below the triangle, as near to its plane as the ear is wide.
    bool is_empty(std::size_t a, std::size_t i, std::size_t b, Vec3d own) const {
        const double width2 = squared_length(point(b) - point(a));
        const std::array<std::size_t, 3> corners{a, i, b};
        for (std::size_t v = next_[b]; v != a; v = next_[v]) {
            const Vec3d p = point(v);
            const double off = dot(p - point(a), own);
            if (off * off > width2 * squared_length(own)) continue;
            bool inside = true;
            for (std::size_t k = 0; k < 3 && inside; ++k) {
                const Vec3d from = point(corners[k]), to = point(corners[(k + 1) % 3]);
                inside = dot(cross(to - from, p - from), own) >= 0.0;
            }
            if (inside) return false;
        }
        return true;
    }

    std::span<const Vec3d> points_;
    const std::function<bool(Index, Index)>& is_edge_;
    const Loop& loop_;
    std::vector<Vec3d> normals_;
    std::vector<std::size_t> next_, before_;
    std::vector<std::uint8_t> is_left_;
    std::priority_queue<Offer> offers_;
};

}  // namespace

bool cut_ears_in_place(std::span<const Vec3d> points, std::size_t num_left,
                       const std::function<bool(Index, Index)>& is_edge, Loop& loop,
                       std::vector<Triangle>& ears) {
    Cutter cutter(points, is_edge, loop);
    const bool is_short = cutter.cut(num_left, ears);
    loop = cutter.rest();
    return is_short;
}

}  // namespace pointbake
