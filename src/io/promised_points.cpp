// Only looks at headers; of a table of text at its first lines, whose length the others are taken
// to have.
#include <algorithm>
#include <charconv>

#include "core/mapped_file.h"
#include "io/input_file.h"
#include "io/las_header.h"
#include "io/number_type.h"
#include "io/pcd_header.h"
#include "io/ply_header.h"
#include "io/read_e57.h"
#include "io/read_las.h"
#include "io/read_pcd.h"
#include "io/read_stl.h"
#include "io/read_text.h"
#include "pointbake/error.h"
#include "pointbake/load.h"

namespace pointbake {
namespace {

using Bytes = std::span<const std::byte>;
using Count = std::optional<std::uint64_t>;

std::string_view as_text(Bytes bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

Count in_ply(Bytes bytes, const std::string& name) {
    const PlyHeader header = read_ply_header(bytes, name);
    const std::optional<std::size_t> vertices = header.find("vertex");
    if (!vertices) return std::nullopt;
    const PlyElement& element = header.elements[*vertices];
    // In text a value takes two bytes at least.
    const std::size_t row_bytes = header.format == PlyFormat::kAscii ? 2 * element.properties.size()
                                                                     : element.min_row_bytes();
    return std::min<std::uint64_t>(element.count,
                                   bytes.size() / std::max<std::size_t>(row_bytes, 1));
}

Count in_pcd(Bytes bytes, const std::string& name) {
    const PcdHeader header = read_pcd_header(as_text(bytes), name);
    if (header.data == PcdData::kCompressed) return header.num_points;
    const std::size_t row_bytes =
        header.data == PcdData::kAscii ? 2 * header.row_values : header.row_bytes;
    return std::min<std::uint64_t>(header.num_points,
                                   bytes.size() / std::max<std::size_t>(row_bytes, 1));
}

Count in_las(Bytes bytes, const std::string& name) {
    const LasHeader header = read_las_header(bytes, name);
    if (header.is_compressed) return header.num_points;
    return std::min<std::uint64_t>(header.num_points,
                                   bytes.size() / std::max<std::size_t>(header.record_bytes, 1));
}

/// The sum of what the XML at the file's end says, wherever it says so.
Count in_e57(Bytes bytes) {
    constexpr std::size_t kXmlPlaceAt = 24;
    if (bytes.size() < kXmlPlaceAt + 8) return std::nullopt;
    const auto xml_at = load_value<std::uint64_t>(bytes.data() + kXmlPlaceAt);
    if (xml_at >= bytes.size()) return std::nullopt;
    constexpr std::string_view kWord = "recordCount=\"";
    std::string_view text = as_text(bytes.subspan(static_cast<std::size_t>(xml_at)));
    std::uint64_t sum = 0;
    for (std::size_t at; (at = text.find(kWord)) != std::string_view::npos;) {
        text.remove_prefix(at + kWord.size());
        std::uint64_t count = 0;
        std::from_chars(text.data(), text.data() + text.size(), count);
        sum += std::min<std::uint64_t>(count, bytes.size());
    }
    return sum;
}

Count in_text(Bytes bytes, const std::string& name) {
    const std::string_view text = as_text(bytes);
    const std::optional<TextLayout> layout = find_text_layout(text, name);
    if (!layout) return std::nullopt;
    constexpr std::size_t kLookAt = std::size_t{1} << 16;
    const std::string_view first = text.substr(layout->begin, kLookAt);
    const auto num_lines = std::ranges::count(first, layout->line_end);
    if (num_lines == 0) return 1;
    return (bytes.size() - layout->begin) * static_cast<std::uint64_t>(num_lines) / first.size();
}

Count in_any(Bytes bytes, const std::filesystem::path& path) {
    const std::string name = path.string();
    if (is_gzip(bytes) || is_zstd(bytes)) return std::nullopt;
    if (is_ply(bytes)) return in_ply(bytes, name);
    constexpr std::size_t kSplatBytes = 32, kFacetBytes = 50;
    if (kind_extension(path) == ".splat") return bytes.size() / kSplatBytes;
    if (is_las(bytes)) return in_las(bytes, name);
    if (is_e57(bytes)) return in_e57(bytes);
    if (is_pcd(bytes)) return in_pcd(bytes, name);
    // Closed meshes have half as many vertices as facets.
    if (is_stl(bytes)) return bytes.size() / kFacetBytes / 2;
    if (is_text_extension(kind_extension(path)) || kind_extension(path) == ".ptx")
        return in_text(bytes, name);
    return std::nullopt;
}

}  // namespace

std::optional<std::uint64_t> promised_points(const std::filesystem::path& path) {
    if (path == "-") return std::nullopt;
    try {
        const MappedFile file(path);
        return in_any(file.bytes(), path);
    } catch (const Error& error) {
        if (error.code() == ErrorCode::kIo) throw;
        return std::nullopt;
    }
}

}  // namespace pointbake
