// Shapes not yet placed, by height and by what their left side looks like.
#pragma once

#include <vector>

#include "atlas/shape_set.h"

namespace pointbake {

/// One entry per shape and pose with a key that says how its left side leans; finds entries of like
/// key. O(n log n) to build, almost constant per step and removal.
class MatchIndex {
 public:
    struct Entry {
        double key = 0.0;
        int rank = 0, pose = 0;
    };
    /// All shapes of one height, tallest class first; entries [begin, end), ranks [first_rank,
    /// last_rank).
    struct HeightClass {
        int height = 0;
        int begin = 0, end = 0;
        int first_rank = 0, last_rank = 0;
        int num_left = 0;
    };

    /// Poses 0 .. num_poses - 1 of every shape; key(rank, pose).
    template <class Key>
    MatchIndex(const ShapeSet& shapes, int num_poses, Key&& key) : num_poses_(num_poses) {
        entries_.reserve(static_cast<std::size_t>(shapes.size() * num_poses));
        for (int rank = 0; rank < shapes.size(); ++rank)
            for (int pose = 0; pose < num_poses; ++pose)
                entries_.push_back({key(rank, pose), rank, pose});
        build(shapes);
    }

    const std::vector<HeightClass>& classes() const { return classes_; }
    const Entry& entry(int i) const { return entries_[static_cast<std::size_t>(i)]; }
    bool is_left(int rank) const {
        const int i = position_[static_cast<std::size_t>(rank * num_poses_)];
        return next_[static_cast<std::size_t>(i)] == i;
    }
    void remove(std::size_t class_index, int rank);

    /// Walks over the entries of a class that are left, by distance of their keys to `key`; of two
    /// equally distant ones the larger first.
    class Walk {
     public:
        Walk(MatchIndex& index, const HeightClass& of, double key);
        /// The next entry, or nullptr after the last one.
        const Entry* next();

     private:
        MatchIndex& index_;
        const HeightClass& class_;
        double key_;
        int up_, down_;
    };

 private:
    void build(const ShapeSet& shapes);
    // The first entry at or after i that is left; at least the class's end if there is none.
    int at_or_after(int i) { return find(next_, i); }
    // The last entry before i that is left; below the class's begin if there is none.
    int before(int i) { return find(previous_, i) - 1; }
    static int find(std::vector<int>& link, int i);

    int num_poses_;
    std::vector<HeightClass> classes_;
    std::vector<Entry> entries_;
    std::vector<int> position_;  // of (rank, pose) in entries_
    std::vector<int> next_;      // next_[i] = i while entry i is left
    std::vector<int> previous_;  // previous_[i + 1] = i + 1 while entry i is left
};

}  // namespace pointbake
