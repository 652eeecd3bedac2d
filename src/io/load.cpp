// Files are told apart by their first bytes: extensions lie.
#include "pointbake/load.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "core/message.h"
#include "core/parallel.h"
#include "io/crs.h"
#include "io/input_file.h"
#include "io/mesh_vertices.h"
#include "io/ply_header.h"
#include "io/read_e57.h"
#include "io/read_gltf.h"
#include "io/read_las.h"
#include "io/read_obj.h"
#include "io/read_off.h"
#include "io/read_pcd.h"
#include "io/read_ply.h"
#include "io/read_ptx.h"
#include "io/read_splats.h"
#include "io/read_stl.h"
#include "io/read_text.h"

namespace pointbake {
namespace {

using Bytes = std::span<const std::byte>;

/// What a file is that is not read, if its first bytes tell; else nothing.
std::string_view kind_of(std::string_view text) {
    constexpr std::array<std::pair<std::string_view, std::string_view>, 3> kKinds{{
        {"PK\x03\x04", "a zip archive"},
        {"\xff\xfe", "text in UTF-16; save it as UTF-8"},
        {"\xfe\xff", "text in UTF-16; save it as UTF-8"},
    }};
    for (const auto& [magic, kind] : kKinds)
        if (text.starts_with(magic)) return kind;
    return {};
}

/// Without the mark of UTF-8 that editors put in front of text. A .splat is told by its name alone
/// and may begin with anything.
Bytes without_mark(Bytes bytes, const std::filesystem::path& path) {
    constexpr std::string_view kMark = "\xef\xbb\xbf";
    if (kind_extension(path) == ".splat") return bytes;
    const bool has_mark = std::ranges::equal(std::as_bytes(std::span(kMark)),
                                             bytes.first(std::min(bytes.size(), kMark.size())));
    return has_mark ? bytes.subspan(kMark.size()) : bytes;
}

std::string_view first_bytes(Bytes bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), std::min<std::size_t>(bytes.size(), 64)};
}

std::string_view all_text(Bytes bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

bool is_gltf(std::string_view text) {
    if (text.starts_with("glTF")) return true;
    const std::size_t begin = text.find_first_not_of(" \t\r\n");
    return begin != std::string_view::npos && text[begin] == '{';
}

LoadResult read_stl_points(Bytes bytes, const std::filesystem::path& path, const Context& context) {
    const StlFile file = read_stl(bytes, path, context);
    LoadResult result = vertices_as_points(file.mesh, "STL", path, context);
    LoadReport& report = result.report;
    report.num_bad_faces += file.num_bad_facets;
    report.notes.insert(report.notes.end(), file.notes.begin(), file.notes.end());
    return result;
}

[[noreturn]] void fail_unknown(Bytes bytes, const std::filesystem::path& path) {
    const std::string_view kind = kind_of(first_bytes(bytes));
    if (kind.empty() && is_text_extension(kind_extension(path))) {
        constexpr std::size_t kLookAt = std::size_t{1} << 16;
        const std::size_t zero = all_text(bytes).substr(0, kLookAt).find('\0');
        if (zero != std::string_view::npos)
            fail(ErrorCode::kInvalidInput,
                 "{}: byte {} is zero, which text has not: it is a binary file, or in UTF-16, or "
                 "damaged",
                 path.string(), zero);
        fail(ErrorCode::kInvalidInput,
             "{}: the first lines are no table: rows of at least three numbers are wanted, with "
             "blanks, commas or semicolons between them",
             path.string());
    }
    fail(ErrorCode::kUnsupported,
         "{}: is {}; points are read from PLY, LAS, LAZ, E57, PCD, PTX, OFF, SPZ, splat and tables "
         "of text, and as "
         "vertices from OBJ, STL, GLB and glTF",
         path.string(), kind.empty() ? "of an unknown kind" : kind);
}

LoadResult with_up(LoadResult result, UpAxis up) {
    result.cloud.frame.up = up;
    return result;
}

/// Those of PTS, which scanners write, have z up.
LoadResult read_table(std::string_view table, const TextLayout& layout,
                      const std::filesystem::path& path, const LoadOptions& options,
                      const Context& context) {
    const UpAxis up = kind_extension(path) == ".pts" ? UpAxis::kZ : UpAxis::kAuto;
    return with_up(read_text(table, layout, path, options, context), up);
}

LoadResult read_any(const std::filesystem::path& path, const LoadOptions& options,
                    const Context& context) {
    const InputFile file(path, context);
    const Bytes bytes = without_mark(file.bytes(), path);
    if (bytes.empty())
        fail(ErrorCode::kInvalidInput, "{}: the file is empty; points are wanted", path.string());
    if (is_ply(bytes)) return read_ply_cloud(bytes, path, context);
    if (is_spz(bytes)) return with_up(read_spz(bytes, path, context), UpAxis::kY);
    if (kind_extension(path) == ".splat") return read_splat(bytes, path, context);
    if (is_las(bytes)) return read_las(bytes, path, context);
    if (is_e57(bytes)) return read_e57(bytes, path, context);
    if (is_pcd(bytes)) return read_pcd(bytes, path, context);
    if (is_gltf(first_bytes(bytes)))
        return with_up(vertices_as_points(read_gltf(bytes, path, context), "glTF", path, context),
                       UpAxis::kY);
    if (is_obj(bytes))
        return vertices_as_points(read_obj(bytes, path, context), "OBJ", path, context);
    const std::string_view text = all_text(bytes);
    if (is_off(text)) return read_off(text, path, context);
    if (is_stl(bytes) || kind_extension(path) == ".stl")
        return read_stl_points(bytes, path, context);
    // A PTX whose first header is damaged must not pass for a table.
    if (is_ptx(text) || kind_extension(path) == ".ptx")
        return with_up(read_ptx(text, path, context), UpAxis::kZ);
    const std::string_view table = text.substr(0, text.find_last_not_of('\0') + 1);  // padded
    if (const std::optional<TextLayout> layout = find_text_layout(table, path.string()))
        return read_table(table, *layout, path, options, context);
    fail_unknown(bytes, path);
}

}  // namespace

LoadResult load_cloud(const std::filesystem::path& path, const LoadOptions& options,
                      const Context& context) {
    check_cancelled(context);
    if (!options.columns.empty()) parse_columns(options.columns);  // a slip is told at once
    report_progress(context, "load", 0.0);
    LoadResult result = read_any(path, options, context);
    if (!options.columns.empty() && !result.report.format.starts_with("text"))
        result.report.notes.emplace_back("--columns not used: it is for tables of text");
    if (const std::string warning = frame_warning(result.cloud.frame); !warning.empty())
        log(context, LogLevel::kWarning, "{}: {}", path.string(), warning);
    return result;
}

TexturedMesh load_mesh(const std::filesystem::path& path, const Context& context) {
    check_cancelled(context);
    const InputFile file(path, context);
    const Bytes bytes = without_mark(file.bytes(), path);
    if (bytes.empty())
        fail(ErrorCode::kInvalidInput,
             "{}: the file is empty; an OBJ, GLB, glTF, PLY, OFF or STL is wanted", path.string());
    if (is_ply(bytes)) return read_ply_mesh(bytes, path, context);
    if (is_gltf(first_bytes(bytes))) return read_gltf(bytes, path, context);
    if (is_obj(bytes)) return read_obj(bytes, path, context);
    if (is_off(all_text(bytes)))
        return faces_as_mesh(read_off(all_text(bytes), path, context), path);
    if (is_stl(bytes) || kind_extension(path) == ".stl") {
        StlFile stl = read_stl(bytes, path, context);
        for (const std::string& note : stl.notes)
            log(context, LogLevel::kWarning, "{}: {}", path.string(), note);
        return std::move(stl.mesh);
    }
    fail(ErrorCode::kUnsupported,
         "{}: neither OBJ, GLB, glTF, PLY, OFF nor STL, which are the meshes read", path.string());
}

}  // namespace pointbake
