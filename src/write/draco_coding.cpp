#include "write/draco_coding.h"

#include <draco/compression/expert_encode.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/message.h"

namespace pointbake {
namespace {

constexpr int kUnitBits = 14;  // of each octahedral coordinate: 1e-4 in angle
constexpr int kMostBits = 30;

draco::GeometryAttribute::Type type_of(std::string_view name) {
    if (name == "POSITION") return draco::GeometryAttribute::POSITION;
    if (name == "NORMAL") return draco::GeometryAttribute::NORMAL;
    if (name == "TEXCOORD_0") return draco::GeometryAttribute::TEX_COORD;
    if (name == "COLOR_0") return draco::GeometryAttribute::COLOR;
    return draco::GeometryAttribute::GENERIC;
}

int add_attribute(draco::Mesh& mesh, const DracoAttribute& attribute, std::size_t num_vertices) {
    const bool is_float = attribute.kind != DracoAttribute::Kind::kExact16;
    const std::size_t stride = attribute.elements.size() / num_vertices;
    draco::GeometryAttribute geometry;
    geometry.Init(type_of(attribute.name), nullptr,
                  static_cast<std::uint8_t>(attribute.num_components),
                  is_float ? draco::DT_FLOAT32 : draco::DT_UINT16, !is_float,
                  static_cast<std::int64_t>(stride), 0);
    const int id = mesh.AddAttribute(geometry, true, static_cast<std::uint32_t>(num_vertices));
    for (std::uint32_t v = 0; v < num_vertices; ++v)
        mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(v),
                                              attribute.elements.data() + v * stride);
    return id;
}

/// A grid of steps of 2^exponent from the lowest value on, as wide as the values are.
void set_grid(draco::ExpertEncoder& encoder, int id, const DracoAttribute& attribute) {
    std::vector<float> values(attribute.elements.size() / sizeof(float));
    std::memcpy(values.data(), attribute.elements.data(), attribute.elements.size());
    const std::size_t n = attribute.num_components;
    const double step = std::ldexp(1.0, attribute.exponent);
    std::vector<float> low(n);
    double most_steps = 1.0;
    for (std::size_t k = 0; k < n; ++k) {
        double lowest = HUGE_VAL, highest = -HUGE_VAL;
        for (std::size_t i = k; i < values.size(); i += n) {
            lowest = std::min(lowest, static_cast<double>(values[i]));
            highest = std::max(highest, static_cast<double>(values[i]));
        }
        lowest = std::floor(lowest / step) * step;
        low[k] = static_cast<float>(lowest);
        most_steps = std::max(most_steps, std::ceil((highest - lowest) / step));
    }
    const int bits = std::ilogb(most_steps) + 1;
    if (bits > kMostBits)
        fail(ErrorCode::kLimit, "--compress draco: {} spans more than 2^{} steps", attribute.name,
             kMostBits);
    // SetAttributeExplicitQuantization() would round its numbers to six decimals.
    draco::Options grid;
    grid.SetInt("quantization_bits", bits);
    grid.SetString("quantization_origin", fmt::format("{}", fmt::join(low, " ")));
    grid.SetString("quantization_range",
                   fmt::format("{}", static_cast<float>(step * (std::ldexp(1.0, bits) - 1.0))));
    encoder.options().SetAttributeOptions(id, grid);
}

}  // namespace

DracoMesh draco_mesh(std::span<const Index> indices, std::span<const DracoAttribute> attributes,
                     std::size_t num_vertices) {
    draco::Mesh mesh;
    mesh.set_num_points(static_cast<std::uint32_t>(num_vertices));
    mesh.SetNumFaces(indices.size() / 3);
    for (std::uint32_t t = 0; t < indices.size() / 3; ++t)
        mesh.SetFace(draco::FaceIndex(t),
                     {draco::PointIndex(indices[3 * t]), draco::PointIndex(indices[3 * t + 1]),
                      draco::PointIndex(indices[3 * t + 2])});
    DracoMesh out;
    for (const DracoAttribute& attribute : attributes)
        out.ids.push_back(add_attribute(mesh, attribute, num_vertices));
    // Equal values make vertices on texture borders neighbours.
    mesh.DeduplicateAttributeValues();

    draco::ExpertEncoder encoder(mesh);
    encoder.SetTrackEncodedProperties(true);
    encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
    for (std::size_t i = 0; i < attributes.size(); ++i) {
        if (attributes[i].kind == DracoAttribute::Kind::kGrid)
            set_grid(encoder, out.ids[i], attributes[i]);
        if (attributes[i].kind == DracoAttribute::Kind::kUnit)
            encoder.SetAttributeQuantization(out.ids[i], kUnitBits);
    }
    draco::EncoderBuffer buffer;
    if (const draco::Status status = encoder.EncodeToBuffer(&buffer); !status.ok())
        fail(ErrorCode::kOutput, "--compress draco: {}", status.error_msg_string());
    const auto* bytes = reinterpret_cast<const std::byte*>(buffer.data());
    out.bytes.assign(bytes, bytes + buffer.size());
    out.num_vertices = encoder.num_encoded_points();
    out.num_triangles = encoder.num_encoded_faces();
    for (int& id : out.ids) id = static_cast<int>(mesh.attribute(id)->unique_id());
    return out;
}

}  // namespace pointbake
