// Texture coordinates per face follow MeshLab: a list texcoord of u, v per corner, and texnumber.
#include "io/ply_faces.h"

#include <algorithm>

namespace pointbake {
namespace {

/// Which property of the element holds what, and which column of a block it becomes.
struct FaceColumns {
    std::vector<std::size_t> properties;
    std::optional<std::size_t> texcoords, texture;
};

std::optional<std::size_t> find_list(const PlyElement& element,
                                     std::initializer_list<std::string_view> names) {
    for (std::string_view name : names) {
        const auto found = element.find(name);
        if (found && element.properties[*found].is_list()) return found;
    }
    return std::nullopt;
}

std::optional<std::size_t> find_corners(const PlyElement& element) {
    return find_list(element, {"vertex_indices", "vertex_index"});
}

FaceColumns find_columns(const PlyElement& element, bool with_texture) {
    FaceColumns columns;
    columns.properties.push_back(*find_corners(element));
    if (!with_texture) return columns;
    if (const auto uv = find_list(element, {"texcoord"})) {
        columns.texcoords = columns.properties.size();
        columns.properties.push_back(*uv);
    }
    if (const auto number = element.find("texnumber");
        number && !element.properties[*number].is_list()) {
        columns.texture = columns.properties.size();
        columns.properties.push_back(*number);
    }
    return columns;
}

/// kInvalidIndex for what is no row, or no point any more.
Index corner_of(double value, std::span<const Index> point_of_row) {
    if (!(value >= 0.0 && value < static_cast<double>(point_of_row.size()))) return kInvalidIndex;
    return point_of_row[static_cast<std::size_t>(value)];
}

bool is_proper(const Triangle& t) { return t[0] != t[1] && t[1] != t[2] && t[2] != t[0]; }

Vec2f uv_of(std::span<const double> texcoords, std::size_t corner) {
    if (texcoords.size() < 2 * corner + 2) return {};
    return {static_cast<float>(texcoords[2 * corner]),
            static_cast<float>(texcoords[2 * corner + 1])};
}

struct FaceBlock {
    const PlyBlock& block;
    const FaceColumns& columns;
    std::span<const Index> point_of_row;

    PlyFaces polygons() const {
        PlyFaces out;
        std::vector<Index> corners;
        for (std::size_t row = 0; row < block.num_rows; ++row) {
            corners.clear();
            for (double value : block.columns[0].list(row))
                corners.push_back(corner_of(value, point_of_row));
            const std::size_t num_before = out.triangles.size();
            if (std::find(corners.begin(), corners.end(), kInvalidIndex) == corners.end())
                add_fan(row, corners, out);
            if (out.triangles.size() == num_before) ++out.num_bad;
        }
        return out;
    }

    void add_fan(std::size_t row, const std::vector<Index>& corners, PlyFaces& out) const {
        for (std::size_t k = 1; k + 1 < corners.size(); ++k) {
            const Triangle triangle{corners[0], corners[k], corners[k + 1]};
            if (!is_proper(triangle)) continue;
            out.triangles.push_back(triangle);
            if (columns.texcoords) {
                const auto uvs = block.columns[*columns.texcoords].list(row);
                out.uvs.push_back({uv_of(uvs, 0), uv_of(uvs, k), uv_of(uvs, k + 1)});
            }
            if (columns.texture) {
                const double number = block.columns[*columns.texture].values[row];
                out.textures.push_back(number >= 0.0 && number < 4294967295.0
                                           ? static_cast<Index>(number)
                                           : kInvalidIndex);
            }
        }
    }

    PlyFaces strips() const {
        PlyFaces out;
        for (std::size_t row = 0; row < block.num_rows; ++row) {
            const std::span<const double> values = block.columns[0].list(row);
            std::size_t start = 0;  // of the strip
            for (std::size_t i = 0; i < values.size(); ++i) {
                if (values[i] < 0.0) {
                    start = i + 1;
                    continue;
                }
                if (i < start + 2) continue;
                Triangle t{corner_of(values[i - 2], point_of_row),
                           corner_of(values[i - 1], point_of_row),
                           corner_of(values[i], point_of_row)};
                if ((i - start) % 2 == 1) std::swap(t[0], t[1]);
                if (std::find(t.begin(), t.end(), kInvalidIndex) != t.end())
                    ++out.num_bad;
                else if (is_proper(t))  // strips repeat corners to turn: no defect
                    out.triangles.push_back(t);
            }
        }
        return out;
    }
};

template <class T>
void append(std::vector<T>& to, std::vector<T>& from) {
    to.insert(to.end(), from.begin(), from.end());
    from = {};
}

}  // namespace

std::optional<std::size_t> find_faces(const PlyHeader& header) {
    for (std::string_view name : {"face", "tristrips"}) {
        const auto found = header.find(name);
        if (found && header.elements[*found].count > 0 && find_corners(header.elements[*found]))
            return found;
    }
    return std::nullopt;
}

PlyFaces read_ply_faces(const PlyBody& body, const PlyHeader& header, std::size_t element,
                        std::span<const Index> point_of_row, bool with_texture,
                        const Context& context) {
    const FaceColumns columns = find_columns(header.elements[element], with_texture);
    const bool are_strips = header.elements[element].name == "tristrips";
    std::vector<PlyFaces> parts(body.num_blocks(element));
    body.read(element, columns.properties, context, [&](const PlyBlock& block) {
        const FaceBlock faces{block, columns, point_of_row};
        parts[block.index] = are_strips ? faces.strips() : faces.polygons();
    });
    PlyFaces out;
    std::size_t num_triangles = 0;
    for (const PlyFaces& part : parts) num_triangles += part.triangles.size();
    out.triangles.reserve(num_triangles);
    for (PlyFaces& part : parts) {
        append(out.triangles, part.triangles);
        append(out.uvs, part.uvs);
        append(out.textures, part.textures);
        out.num_bad += part.num_bad;
    }
    return out;
}

}  // namespace pointbake
