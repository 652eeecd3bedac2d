// A priority queue of vertices whose costs change while they wait.
#pragma once

#include <utility>
#include <vector>

#include "pointbake/types.h"

namespace pointbake {

/// Binary heap with the smallest (cost, id) on top; ids are 0 .. capacity - 1, each in it at most
/// once.
class IndexedHeap {
 public:
    struct Item {
        float cost;
        Index id;
        friend bool operator<(const Item& x, const Item& y) {
            return x.cost != y.cost ? x.cost < y.cost : x.id < y.id;
        }
    };

    explicit IndexedHeap(std::size_t capacity) : slots_(capacity, kInvalidIndex) {}

    bool empty() const { return items_.empty(); }
    Item top() const { return items_.front(); }

    /// Inserts the id, or changes its cost.
    void set(Index id, float cost) {
        std::size_t slot = slots_[id];
        if (slot == kInvalidIndex) {
            slot = items_.size();
            items_.push_back({cost, id});
        }
        place(slot, {cost, id});
    }
    void remove(Index id) {
        const std::size_t slot = slots_[id];
        if (slot == kInvalidIndex) return;
        slots_[id] = kInvalidIndex;
        const Item last = items_.back();
        items_.pop_back();
        if (slot < items_.size()) place(slot, last);
    }

 private:
    void place(std::size_t slot, Item item) {
        while (slot > 0 && item < items_[(slot - 1) / 2]) {
            put(slot, items_[(slot - 1) / 2]);
            slot = (slot - 1) / 2;
        }
        for (std::size_t child = 2 * slot + 1; child < items_.size(); child = 2 * slot + 1) {
            if (child + 1 < items_.size() && items_[child + 1] < items_[child]) ++child;
            if (!(items_[child] < item)) break;
            put(slot, items_[child]);
            slot = child;
        }
        put(slot, item);
    }
    void put(std::size_t slot, Item item) {
        items_[slot] = item;
        slots_[item.id] = static_cast<Index>(slot);
    }

    std::vector<Item> items_;
    std::vector<Index> slots_;
};

}  // namespace pointbake
