// Binary: 80 bytes of anything, a count, and for each triangle a normal, three corners and two more
// bytes. A binary file may begin with "solid", too, so that its size is asked first.
#include "io/read_stl.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "core/message.h"
#include "core/parallel.h"
#include "io/finish_cloud.h"
#include "io/mesh_builder.h"
#include "io/number_type.h"
#include "io/text_rows.h"

namespace pointbake {
namespace {

constexpr std::size_t kHeaderBytes = 84, kFacetBytes = 50, kNormalBytes = 12;
constexpr std::size_t kFacetsPerPoll = std::size_t{1} << 16;

using Bytes = std::span<const std::byte>;

std::string_view as_text(Bytes bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::uint64_t promised_facets(Bytes bytes) {
    return load_value<std::uint32_t>(bytes.data() + kHeaderBytes - 4);
}

bool is_binary(Bytes bytes) {
    return bytes.size() >= kHeaderBytes + kFacetBytes &&
           bytes.size() == kHeaderBytes + kFacetBytes * promised_facets(bytes);
}

bool begins_with_word(std::string_view line, std::string_view word) {
    if (line.size() < word.size()) return false;
    for (std::size_t i = 0; i < word.size(); ++i)
        if ((line[i] | 0x20) != word[i]) return false;
    return line.size() == word.size() || line[word.size()] == ' ' || line[word.size()] == '\t';
}

bool is_text(Bytes bytes) {
    constexpr std::size_t kLookAt = 4096;
    std::string_view text = as_text(bytes.first(std::min(bytes.size(), kLookAt)));
    const char line_end = line_end_of(text);
    bool has_solid = false;
    while (!text.empty()) {
        const std::string_view line = take_line(text, line_end);
        if (line.empty()) continue;
        if (has_solid) return begins_with_word(line, "facet") || begins_with_word(line, "endsolid");
        if (!begins_with_word(line, "solid")) return false;
        has_solid = true;
    }
    return false;
}

/// A facet of three corners or more becomes a fan of triangles; fewer, or one that is not finite,
/// make it a bad one.
void add_facet(std::span<const Vec3d> corners, StlFile& file, const std::string& name) {
    Mesh& mesh = file.mesh.mesh;
    if (corners.size() < 3 || !std::all_of(corners.begin(), corners.end(), is_finite<double>)) {
        ++file.num_bad_facets;
        return;
    }
    if (corners.size() >= kInvalidIndex - mesh.positions.size())
        fail(ErrorCode::kLimit, "{}: more than {} corners of triangles", name, kInvalidIndex - 1);
    const auto first = static_cast<Index>(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(), corners.begin(), corners.end());
    for (Index k = 1; k + 1 < corners.size(); ++k)
        mesh.triangles.push_back({first, first + k, first + k + 1});
}

StlFile read_binary(Bytes bytes, const std::string& name, const Context& context) {
    if (bytes.size() < kHeaderBytes)
        fail(ErrorCode::kInvalidInput, "{}: {} bytes are no STL file: its header has {}", name,
             bytes.size(), kHeaderBytes);
    const std::uint64_t num_there = (bytes.size() - kHeaderBytes) / kFacetBytes;
    if (promised_facets(bytes) > num_there)
        fail(ErrorCode::kInvalidInput,
             "{}: the header promises {} triangles, but bytes are there for only {}: the file is "
             "cut off, or it is no STL",
             name, promised_facets(bytes), num_there);
    StlFile file;
    for (std::size_t i = 0; i < promised_facets(bytes); ++i) {
        if (i % kFacetsPerPoll == 0) check_cancelled(context);
        const std::byte* const from = bytes.data() + kHeaderBytes + i * kFacetBytes + kNormalBytes;
        std::array<Vec3d, 3> corners;
        for (std::size_t c = 0; c < 3; ++c)
            for (std::size_t k = 0; k < 3; ++k)
                corners[c][k] = static_cast<double>(load_value<float>(from + 12 * c + 4 * k));
        add_facet(corners, file, name);
    }
    return file;
}

StlFile read_text(std::string_view text, const std::string& name, const Context& context) {
    const char line_end = line_end_of(text);
    StlFile file;
    std::vector<Vec3d> loop;
    bool is_closed = false;  // by endsolid
    std::size_t line_number = 0;
    for (std::string_view rest = text; !rest.empty();) {
        const std::string_view line = take_line(rest, line_end);
        if (++line_number % kFacetsPerPoll == 0) check_cancelled(context);
        if (!line.empty()) is_closed = begins_with_word(line, "endsolid");
        if (begins_with_word(line, "outer")) loop.clear();
        if (begins_with_word(line, "vertex")) {
            Vec3d corner;
            Fields fields(line.substr(6));
            for (std::size_t k = 0; k < 3; ++k)
                if (!fields.number(corner[k]))
                    fail(ErrorCode::kInvalidInput, "{}:{}: 'vertex' wants three numbers", name,
                         line_number);
            loop.push_back(corner);
        }
        if (begins_with_word(line, "endloop")) {
            add_facet(loop, file, name);
            loop.clear();
        }
    }
    if (!loop.empty())
        fail(ErrorCode::kInvalidInput, "{}:{}: the file is cut off within a facet", name,
             line_number);
    if (!is_closed) file.notes.emplace_back("no 'endsolid' at the end: the file may be cut off");
    return file;
}

}  // namespace

bool is_stl(Bytes bytes) { return is_binary(bytes) || is_text(bytes); }

StlFile read_stl(Bytes bytes, const std::filesystem::path& path, const Context& context) {
    const std::string name = path.string();
    StlFile file = !is_binary(bytes) && is_text(bytes) ? read_text(as_text(bytes), name, context)
                                                       : read_binary(bytes, name, context);
    file.mesh = finish_mesh(std::move(file.mesh), name);
    if (file.num_bad_facets > 0)
        file.notes.push_back(
            fmt::format("{} dropped: fewer than three corners, or coordinates that are not finite",
                        counted(file.num_bad_facets, "facet")));
    return file;
}

}  // namespace pointbake
