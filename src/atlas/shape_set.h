// The shapes to be packed, in flat arrays and in an order that does not depend on the caller's.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "atlas/tints.h"
#include "pointbake/atlas.h"

namespace pointbake {

/// A pose is which profile of the shape points left: as given, mirrored in x, in y, in both.
inline constexpr int kNumPoses = 4;
constexpr bool is_mirrored_x(int pose) { return (pose & 1) != 0; }
constexpr bool is_mirrored_y(int pose) { return (pose & 2) != 0; }
/// The pose whose left profile is this one's right profile.
constexpr int opposite_side(int pose) { return pose ^ 1; }

/// Profiles are padded to blocks of this many rows, so that loops over them run in whole registers.
inline constexpr int kBlock = 8;
constexpr int num_blocks(int rows) { return (rows + kBlock - 1) / kBlock; }
/// The padding: farther left than any edge.
inline constexpr std::int16_t kNoEdge = INT16_MAX;

/// Shapes by rank: tallest first, then by width and rows, and by position in the input
/// only where two are the same. So the packing does not depend on the order in which shapes come.
class ShapeSet {
 public:
    explicit ShapeSet(std::span<const PatchShape> shapes);

    struct Item {
        Index shape = 0;  ///< position in the input
        int height = 0, width = 0;
        int num_texels = 0;
        std::size_t first = 0;  ///< of its four profiles, each of num_blocks(height) blocks
        int group = 0;          ///< the same for shapes with the same rows
    };
    const std::vector<Item>& items() const { return items_; }
    int size() const { return static_cast<int>(items_.size()); }
    const Item& operator[](int rank) const { return items_[static_cast<std::size_t>(rank)]; }
    std::int64_t num_texels() const { return num_texels_; }
    int max_width() const { return max_width_; }
    int max_height() const { return max_height_; }
    const Tints& tints() const { return tints_; }

    /// Free texels left of each row of the bounding box.
    const std::int16_t* left_profile(int rank, int pose) const {
        const Item& item = (*this)[rank];
        return profiles_.data() + item.first +
               static_cast<std::size_t>(pose * num_blocks(item.height) * kBlock);
    }

 private:
    std::vector<Item> items_;
    std::vector<std::int16_t> profiles_;
    std::int64_t num_texels_ = 0;
    int max_width_ = 0, max_height_ = 0;
    Tints tints_;
};

/// Throws Error{kInvalidInput} unless every row of every shape has a texel and the first column is
/// used; Error{kLimit} if one is wider or higher than the given page.
void validate(std::span<const PatchShape> shapes, PageSize page);

}  // namespace pointbake
