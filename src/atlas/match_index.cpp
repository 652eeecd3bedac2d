// Sorted arrays whose removed entries are skipped by links with path halving [Tarjan84].
#include "atlas/match_index.h"

#include <algorithm>
#include <numeric>

namespace pointbake {

void MatchIndex::build(const ShapeSet& shapes) {
    for (int rank = 0; rank < shapes.size(); ++rank) {
        const int height = shapes[rank].height;
        if (classes_.empty() || classes_.back().height != height)
            classes_.push_back({height, rank * num_poses_, 0, rank, rank, 0});
        HeightClass& c = classes_.back();
        c.end = (rank + 1) * num_poses_;
        c.last_rank = rank + 1;
        ++c.num_left;
    }
    position_.resize(entries_.size());
    for (const HeightClass& c : classes_) {
        std::sort(entries_.begin() + c.begin, entries_.begin() + c.end,
                  [](const Entry& a, const Entry& b) {
                      if (a.key != b.key) return a.key < b.key;
                      return a.rank != b.rank ? a.rank < b.rank : a.pose < b.pose;
                  });
    }
    for (std::size_t i = 0; i < entries_.size(); ++i)
        position_[static_cast<std::size_t>(entries_[i].rank * num_poses_ + entries_[i].pose)] =
            static_cast<int>(i);
    next_.resize(entries_.size() + 1);
    std::iota(next_.begin(), next_.end(), 0);
    previous_ = next_;
}

int MatchIndex::find(std::vector<int>& link, int i) {
    while (link[static_cast<std::size_t>(i)] != i) {
        int& to = link[static_cast<std::size_t>(i)];
        to = link[static_cast<std::size_t>(to)];
        i = to;
    }
    return i;
}

void MatchIndex::remove(std::size_t class_index, int rank) {
    --classes_[class_index].num_left;
    for (int pose = 0; pose < num_poses_; ++pose) {
        const int i = position_[static_cast<std::size_t>(rank * num_poses_ + pose)];
        next_[static_cast<std::size_t>(i)] = i + 1;
        previous_[static_cast<std::size_t>(i) + 1] = i;
    }
}

MatchIndex::Walk::Walk(MatchIndex& index, const HeightClass& of, double key)
    : index_(index), class_(of), key_(key) {
    const auto first = index.entries_.begin();
    const auto at = std::lower_bound(first + of.begin, first + of.end, key,
                                     [](const Entry& e, double value) { return e.key < value; });
    const int i = static_cast<int>(at - first);
    up_ = index.at_or_after(i);
    down_ = index.before(i);
}

const MatchIndex::Entry* MatchIndex::Walk::next() {
    const bool has_up = up_ < class_.end, has_down = down_ >= class_.begin;
    if (!has_up && !has_down) return nullptr;
    const bool goes_up =
        has_up && (!has_down || index_.entry(up_).key - key_ <= key_ - index_.entry(down_).key);
    const Entry& e = index_.entry(goes_up ? up_ : down_);
    if (goes_up)
        up_ = index_.at_or_after(up_ + 1);
    else
        down_ = index_.before(down_);
    return &e;
}

}  // namespace pointbake
