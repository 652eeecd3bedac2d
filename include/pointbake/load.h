// Stage 1: a file becomes a point cloud (and, where it holds faces, a mesh).
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pointbake/context.h"
#include "pointbake/options.h"
#include "pointbake/types.h"

namespace pointbake {

struct LoadOptions {
    std::string columns;  ///< empty: told by the header line, else by number and ranges
    template <class Field>
    static void describe(Field&& field) {
        field(
            "columns", &LoadOptions::columns,
            "names of a text table's columns, like x,y,z,red,green,blue,-,intensity; - leaves one "
            "out (default: told by its header, else by what the columns hold)");
    }
};

/// What was found in the file and what was done about it.
struct LoadReport {
    std::string format;                ///< "PLY binary_little_endian", ...
    std::uint64_t num_rows = 0;        ///< point rows in the file
    std::uint64_t num_kept = 0;        ///< points of the cloud
    std::uint64_t num_non_finite = 0;  ///< rows dropped because a coordinate is NaN or infinite
    std::uint64_t num_left_out =
        0;  ///< rows dropped for another reason: a note says which, `cloud.dropped` row by row
    std::uint64_t num_merged = 0;  ///< rows merged into another one with the same coordinates
    std::uint64_t num_zero_normals = 0;
    std::uint64_t num_bad_faces =
        0;                        ///< faces dropped: bad index, fewer than three different corners
    std::vector<Vec3d> scanners;  ///< where they stood
    std::string guess;  ///< what the reader had to guess and an option overrules; empty = nothing
    std::vector<std::string>
        notes;  ///< decisions, one line each ("16-bit colours", "faces ignored: ...")
};

struct LoadResult {
    PointCloud cloud;
    std::optional<Mesh>
        mesh;  ///< faces of the file; positions are the cloud's points, in the cloud's order
    LoadReport report;
};

/// Reads a point cloud: PLY, LAS, LAZ, E57, PCD, PTX, OFF, tables of text, Gaussian splats; of OBJ,
/// STL, GLB and glTF the vertices. The kind is told by content, then by extension. Rows with
/// non-finite coordinates are dropped, rows with equal coordinates merged (colour: mean in linear
/// light); both are counted. Points come in Morton order, ties by row. O(n log n). Throws
/// Error{kIo, kInvalidInput, kUnsupported, kEmpty}.
LoadResult load_cloud(const std::filesystem::path& path, const LoadOptions& options = {},
                      const Context& context = {});

/// How many points a file promises, as its header or its size tells, but no more than fit into it;
/// nothing where only reading all of it would tell (packed files, standard input, OBJ, glTF) and
/// for files that are not read. A forecast: load_cloud says what is wrong with a file. O(1) for
/// most kinds, O(bytes of the XML) for E57. Throws Error{kIo}.
std::optional<std::uint64_t> promised_points(const std::filesystem::path& path);

/// The points of all files, as if they stood in one after the other: rows count on from file to
/// file. Attributes that not all files have are left out, with a note; so are faces. The frame is
/// the first file's, with a warning where others have another one. One file is handed back as it
/// is.
LoadResult merge_clouds(std::vector<LoadResult> parts, const Context& context = {});

/// Reads a mesh with its textures: OBJ (+ MTL, PNG, JPEG), GLB, glTF, PLY (vertex colours, texture
/// coordinates). Polygons are split into fans. Throws as above.
TexturedMesh load_mesh(const std::filesystem::path& path, const Context& context = {});

}  // namespace pointbake
