// Disjoint sets.
#pragma once

#include <algorithm>
#include <numeric>
#include <vector>

#include "pointbake/types.h"

namespace pointbake {

/// Sets of 0 .. n - 1, each named by its lowest member once every member was looked up. Near
/// linear.
class UnionFind {
 public:
    explicit UnionFind(std::size_t n) : parent_(n) {
        std::iota(parent_.begin(), parent_.end(), Index{0});
    }

    /// Adds a set of one; returns its member.
    Index add() {
        parent_.push_back(static_cast<Index>(parent_.size()));
        return parent_.back();
    }
    Index find(Index i) {
        while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
        return i;
    }
    void unite(Index a, Index b) {
        a = find(a), b = find(b);
        parent_[std::max(a, b)] = std::min(a, b);
    }
    std::size_t size() const { return parent_.size(); }

 private:
    std::vector<Index> parent_;
};

}  // namespace pointbake
