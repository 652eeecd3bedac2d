// Cleaning, before anything else is computed: what is no part of the model goes, with a reason.
#pragma once

#include <optional>

#include "pointbake/context.h"
#include "pointbake/options.h"
#include "pointbake/types.h"

namespace pointbake {

/// What to do with points that look wrong.
enum class Unwanted { kDrop, kKeep };
template <>
struct EnumWords<Unwanted> {
    static constexpr std::string_view words[] = {"drop", "keep"};
};

struct CleanOptions {
    std::optional<Box> crop = {};  ///< in the file's coordinates; its sides belong to it
    Unwanted outliers = Unwanted::kDrop;
    Unwanted floaters = Unwanted::kDrop;
    std::optional<Length> subsample = {};
    template <class Field>
    static void describe(Field&& field) {
        field("crop", &CleanOptions::crop,
              "drop points outside of this box, in the file's own coordinates");
        field("outliers", &CleanOptions::outliers,
              "single points off the surface, told by the distances to their neighbours");
        field("floaters", &CleanOptions::floaters,
              "floating pieces of less than 100 points and less than 0.1 % of the largest piece");
        field("subsample", &CleanOptions::subsample,
              "thin the points: no two that are kept lie nearer to each other than this");
    }
};

struct CleanReport {
    std::uint64_t num_cropped = 0;
    std::uint64_t num_outliers = 0;
    std::uint64_t num_floating = 0;         ///< points of floating pieces
    std::uint64_t num_floating_pieces = 0;  ///< the pieces
    std::uint64_t num_subsampled = 0;

    std::uint64_t num_dropped() const {
        return num_cropped + num_outliers + num_floating + num_subsampled;
    }
};

struct CleanResult {
    PointCloud cloud;
    CleanReport report;
};

/// Throws Error{kInvalidOption} for a box without inside and for a spacing that is not positive.
void validate(const CleanOptions& options);

/// Crops, drops outliers and floating pieces [Rusu08, Breunig00], and thins what is left, in this
/// order; dropped points go to cloud.dropped with their row and reason. Lengths in percent are of
/// the bounding-box diagonal of the points before thinning. Fewer than 100 points have neither
/// outliers nor floating pieces. Expects what load_cloud hands on: finite coordinates, no two
/// points in one place. The cloud is taken by value and handed back. O(n log n), one pass of
/// nearest-neighbour queries; the same points for any number of threads, and in any order of the
/// points where no two neighbours are at one distance. Throws Error{kInvalidOption};
/// Error{kEmpty} if the box leaves nothing; Error{kInvalidInput} for coordinates beyond 1e15 and
/// for points that span less than 1e-12.
CleanResult clean(PointCloud cloud, const CleanOptions& options = {}, const Context& context = {});

}  // namespace pointbake
