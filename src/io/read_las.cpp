#include "io/read_las.h"

#include <cstring>

#include "core/message.h"
#include "core/parallel.h"
#include "io/finish_cloud.h"
#include "io/las_header.h"
#include "io/las_points.h"
#include "io/read_laz.h"

namespace pointbake {
namespace {

using Bytes = std::span<const std::byte>;

constexpr std::size_t kBlockRows = 8192;

void read_records(Bytes bytes, const LasHeader& header, const std::string& name, LasPoints& points,
                  const Context& context) {
    const std::uint64_t num_there = (bytes.size() - header.points_at) / header.record_bytes;
    if (header.num_points > num_there)
        fail(ErrorCode::kInvalidInput,
             "{}: the header promises {} points, but bytes are there for only {} (the file ends at "
             "byte {}): it is cut off, or the header is wrong",
             name, header.num_points, num_there, bytes.size());
    points.allocate();
    const std::byte* const records = bytes.data() + header.points_at;
    parallel_for(context, static_cast<std::size_t>(header.num_points), kBlockRows,
                 [&](std::size_t begin, std::size_t end) {
                     points.store(begin, end - begin, records + begin * header.record_bytes);
                 });
}

/// Returns a note, or nothing.
std::string read_compressed(Bytes bytes, const LasHeader& header, const std::string& name,
                            LasPoints& points, const Context& context) {
    const LazSink sink{[&] { points.allocate(); },
                       [&](std::size_t first_row, std::size_t num_rows, const std::byte* records) {
                           points.store(first_row, num_rows, records);
                       }};
    return unpack_laz(bytes, header, name, sink, context);
}

}  // namespace

bool is_las(Bytes bytes) { return bytes.size() >= 4 && std::memcmp(bytes.data(), "LASF", 4) == 0; }

LoadResult read_las(Bytes bytes, const std::filesystem::path& path, const Context& context) {
    const std::string name = path.string();
    const LasHeader header = read_las_header(bytes, name);
    LasPoints points(header, name);
    std::string note;
    if (header.is_compressed)
        note = read_compressed(bytes, header, name, points, context);
    else
        read_records(bytes, header, name, points, context);
    PointRows rows = points.finish(context);
    rows.cloud.frame = header.frame;
    if (!note.empty()) rows.notes.push_back(std::move(note));
    report_progress(context, "load", 0.5);
    LoadResult result =
        finish_cloud(std::move(rows),
                     fmt::format("{} 1.{}, point format {}", header.is_compressed ? "LAZ" : "LAS",
                                 header.minor_version, header.point_format),
                     name, context)
            .result;
    report_progress(context, "load", 1.0);
    return result;
}

}  // namespace pointbake
