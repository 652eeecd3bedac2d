#include "pointbake/clean.h"

#include <algorithm>
#include <cmath>

#include "clean/floaters.h"
#include "clean/neighborhoods.h"
#include "clean/outliers.h"
#include "clean/subsample.h"
#include "core/message.h"
#include "core/select_points.h"

namespace pointbake {
namespace {

// Fewer points say too little about what is usual among them.
constexpr std::size_t kFewestPoints = 100;

bool contains(const Box& box, Vec3d p) {
    return box.low.x <= p.x && p.x <= box.high.x && box.low.y <= p.y && p.y <= box.high.y &&
           box.low.z <= p.z && p.z <= box.high.z;
}

void crop(CleanResult& result, const Box& box) {
    std::vector<DropReason> fates(result.cloud.size(), DropReason::kKept);
    for (std::size_t i = 0; i < fates.size(); ++i) {
        if (contains(box, result.cloud.positions[i])) continue;
        fates[i] = DropReason::kCropped;
        ++result.report.num_cropped;
    }
    if (result.report.num_cropped == fates.size())
        fail(ErrorCode::kEmpty, "--crop {} leaves none of the {} points", to_string(box),
             fates.size());
    result.cloud = select_points(std::move(result.cloud), fates);
}

// Squares of areas and the like must stay numbers.
void check_reach(const PointCloud& cloud) {
    constexpr double kMost = 1e15, kLeast = 1e-12;
    Box box;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
        const Vec3d& p = cloud.positions[i];
        box.extend(p);
        if (std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) > kMost)
            fail(ErrorCode::kInvalidInput,
                 "point {} lies at {:.4g} {:.4g} {:.4g}: coordinates of at most {:.0e} are "
                 "accepted (--crop drops others)",
                 i < cloud.rows.size() ? cloud.rows[i] : i, p.x, p.y, p.z, kMost);
    }
    const double diagonal = box.diagonal();
    if (cloud.size() > 1 && diagonal > 0.0 && diagonal < kLeast)
        fail(ErrorCode::kInvalidInput, "the points span {:.2g}: at least {:.0e} is accepted",
             diagonal, kLeast);
}

void drop_unwanted(CleanResult& result, const CleanOptions& options, const Context& context) {
    std::vector<DropReason> fates(result.cloud.size(), DropReason::kKept);
    const Neighborhoods near = find_neighborhoods(result.cloud.positions, context);
    if (options.outliers == Unwanted::kDrop)
        result.report.num_outliers = mark_outliers(near, fates, context);
    if (options.floaters == Unwanted::kDrop) {
        const FloaterCounts counts = mark_floaters(near, fates, context);
        result.report.num_floating = counts.num_points;
        result.report.num_floating_pieces = counts.num_pieces;
    }
    result.cloud = select_points(std::move(result.cloud), fates);
}

void thin(CleanResult& result, const Length& spacing, const Context& context) {
    Box box;
    for (const Vec3d& p : result.cloud.positions) box.extend(p);
    std::vector<DropReason> fates(result.cloud.size(), DropReason::kKept);
    result.report.num_subsampled =
        mark_subsampled(result.cloud.positions, spacing.in_units(box.diagonal()), fates, context);
    result.cloud = select_points(std::move(result.cloud), fates);
}

}  // namespace

void validate(const CleanOptions& options) {
    if (options.crop)
        for (std::size_t k = 0; k < 3; ++k)
            if (!(options.crop->low[k] <= options.crop->high[k]))
                fail(ErrorCode::kInvalidOption,
                     "crop is {}: the lower bounds x0,y0,z0 come first, then the upper ones",
                     to_string(*options.crop));
    if (options.subsample && !(options.subsample->value > 0.0))
        fail(ErrorCode::kInvalidOption, "subsample is {}: a length above 0 is accepted",
             to_string(*options.subsample));
}

CleanResult clean(PointCloud cloud, const CleanOptions& options, const Context& context) {
    validate(options);
    CleanResult result{.cloud = std::move(cloud), .report = {}};
    if (options.crop) crop(result, *options.crop);
    check_reach(result.cloud);
    const bool keeps_all =
        options.outliers == Unwanted::kKeep && options.floaters == Unwanted::kKeep;
    if (!keeps_all && result.cloud.size() >= kFewestPoints) drop_unwanted(result, options, context);
    if (options.subsample && result.cloud.size() > 0) thin(result, *options.subsample, context);
    return result;
}

}  // namespace pointbake
