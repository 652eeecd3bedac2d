// What a run has to tell, as JSON; and what a cloud is like, for whoever looks before converting.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "pointbake/convert.h"
#include "pointbake/load.h"
#include "pointbake/types.h"
#include "pointbake/write.h"

namespace pointbake {

/// The program's version, "0.1.0".
std::string_view version();

/// Values of a distribution below which a share of it lies.
struct Quantiles {
    double min = 0.0, p05 = 0.0, p25 = 0.0, median = 0.0, p75 = 0.0, p95 = 0.0, p99 = 0.0,
           max = 0.0;
};
/// O(n log n). Values that are not finite are left out; all zero if none remain.
Quantiles quantiles(std::vector<double> values);

/// One attribute that the points carry.
struct AttributeRange {
    std::string name;  ///< "colors", "normals", ..., or the channel's name
    std::string unit;
    std::uint64_t num_known = 0;   ///< points that have it (a zero normal is unknown)
    double low = 0.0, high = 0.0;  ///< over all components
};

struct CloudSummary {
    std::uint64_t num_points = 0;
    Box box;
    Quantiles spacing;  ///< distance of each point to its nearest neighbour
    std::vector<AttributeRange> attributes;
    Frame frame;
    bool are_splats = false;  ///< elliptical, with opacities
};

/// O(n log n), a few seconds for ten million points.
CloudSummary summarize(const PointCloud& cloud, const Context& context = {});

/// What a conversion is expected to need at most, in bytes.
std::uint64_t predicted_memory(std::uint64_t num_points, bool are_splats);

/// All that is known at the end of a conversion. Sections of stages after `last_stage` are left
/// out.
struct RunReport {
    std::string input, output;   ///< as given
    std::string options = "{}";  ///< JSON object of the options that shape the result
    LoadReport load;
    Frame frame;  ///< as the input tells it; write.frame is what was made of it
    ConvertReport convert;
    WriteReport write;
    Stage last_stage = Stage::kWrite;
    Quantiles point_distances;      ///< of kept points to the mesh, cloud units
    Quantiles points_per_triangle;  ///< points whose nearest triangle it is
    double seconds = 0.0;           ///< the whole run
    int threads = 0;
    std::uint64_t peak_bytes = 0;
};

/// Distributions that follow from the light mesh.
void add_distributions(RunReport& report, const SimplifyResult& light);

/// The report as an indented JSON object. Everything that changes from run to run (seconds, memory,
/// threads) is in its last member, "timings"; the rest is the same bytes for the same input and
/// options. Infinite bounds are null.
std::string report_json(const RunReport& report);

/// What `info` tells: the file, its points, its defects.
std::string info_json(std::string_view file, const LoadReport& load, const CloudSummary& cloud,
                      std::uint64_t num_faces);

}  // namespace pointbake
