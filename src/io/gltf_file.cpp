// Based on the Khronos glTF 2.0 specification [glTF2], 3.6 (binary data), 4 (GLB).
#include "io/gltf_file.h"

#include <array>
#include <bit>
#include <cstring>

#include "core/message.h"
#include "io/image_io.h"

namespace pointbake {
namespace {

constexpr std::uint32_t kJsonChunk = 0x4E4F534A;
constexpr std::uint32_t kBinaryChunk = 0x004E4942;
static_assert(std::endian::native == std::endian::little, "glTF is little endian");

template <class T>
T load(const std::byte* from) {
    T value;
    std::memcpy(&value, from, sizeof(T));
    return value;
}

std::optional<std::size_t> width_of(const std::string& type) {
    constexpr std::array<std::pair<std::string_view, std::size_t>, 4> kWidths{
        {{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}}};
    for (const auto& [name, width] : kWidths)
        if (name == type) return width;
    return std::nullopt;
}

std::size_t component_bytes(std::size_t type) {
    switch (type) {
        case 5120:
        case 5121:
            return 1;
        case 5122:
        case 5123:
            return 2;
        case 5125:
        case 5126:
            return 4;
        default:
            return 0;
    }
}

double load_component(std::size_t type, const std::byte* from) {
    switch (type) {
        case 5120:
            return load<std::int8_t>(from);
        case 5121:
            return load<std::uint8_t>(from);
        case 5122:
            return load<std::int16_t>(from);
        case 5123:
            return load<std::uint16_t>(from);
        case 5125:
            return load<std::uint32_t>(from);
        default:
            return static_cast<double>(load<float>(from));
    }
}

/// Largest value of an integer type, which normalised values count as 1.
double component_max(std::size_t type) {
    switch (type) {
        case 5120:
            return 127.0;
        case 5121:
            return 255.0;
        case 5122:
            return 32767.0;
        case 5123:
            return 65535.0;
        default:
            return 1.0;
    }
}

int hex_value(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    return -1;
}

/// "%20" and the like.
std::string decode_percent(std::string_view uri) {
    std::string out;
    for (std::size_t i = 0; i < uri.size(); ++i) {
        const int high = uri[i] == '%' && i + 2 < uri.size() ? hex_value(uri[i + 1]) : -1;
        const int low = high >= 0 ? hex_value(uri[i + 2]) : -1;
        if (low < 0) {
            out += uri[i];
        } else {
            out += static_cast<char>(high * 16 + low);
            i += 2;
        }
    }
    return out;
}

int base64_value(char c) {
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    if (c == '+' || c == '-') return 62;
    if (c == '/' || c == '_') return 63;
    return -1;
}

std::optional<std::vector<std::byte>> decode_base64(std::string_view text) {
    while (text.ends_with('=')) text.remove_suffix(1);
    std::vector<std::byte> out;
    out.reserve(text.size() / 4 * 3 + 3);
    std::uint32_t bits = 0;
    int num_bits = 0;
    for (char c : text) {
        const int value = base64_value(c);
        if (value < 0) return std::nullopt;
        bits = bits << 6 | static_cast<std::uint32_t>(value);
        num_bits += 6;
        if (num_bits < 8) continue;
        num_bits -= 8;
        out.push_back(static_cast<std::byte>(bits >> num_bits & 0xffU));
    }
    return out;
}

/// Whether a path leads nowhere but into the folder that it is relative to.
bool stays_inside(const std::filesystem::path& path) {
    const std::filesystem::path normal = path.lexically_normal();
    return normal.is_relative() && !normal.empty() && *normal.begin() != "..";
}

}  // namespace

GltfFile::GltfFile(std::span<const std::byte> bytes, const std::filesystem::path& path)
    : folder_(path.parent_path()), name_(path.string()) {
    read_container(bytes);
    if (!json_.is_object()) fail(ErrorCode::kInvalidInput, "{}: the JSON text is no object", name_);
    const auto buffers = json_.find("buffers");
    if (buffers == json_.end() || !buffers->is_array()) return;
    for (const Json& buffer : *buffers) {
        const auto uri = buffer.find("uri");
        if (uri == buffer.end() || !uri->is_string()) {
            buffers_.push_back({{}, nullptr, binary_});
        } else {
            const auto& name = uri->get_ref<const std::string&>();
            // Bytes of any file would pass for coordinates.
            if (!name.starts_with("data:") && !stays_inside(decode_percent(name)))
                fail(ErrorCode::kInvalidInput,
                     "{}: buffers[{}] is '{}'; a file in the same folder or below is wanted", name_,
                     buffers_.size(), name);
            buffers_.push_back(read_uri(name));
        }
    }
}

void GltfFile::read_container(std::span<const std::byte> bytes) {
    const auto parse = [&](std::span<const std::byte> text) {
        const char* begin = reinterpret_cast<const char*>(text.data());
        try {
            json_ = Json::parse(begin, begin + text.size());
        } catch (const Json::exception& e) {
            fail(ErrorCode::kInvalidInput, "{}: not valid JSON: {}", name_, e.what());
        }
    };
    if (bytes.size() < 12 || load<std::uint32_t>(bytes.data()) != 0x46546C67) return parse(bytes);
    const auto version = load<std::uint32_t>(bytes.data() + 4);
    if (version != 2)
        fail(ErrorCode::kUnsupported, "{}: GLB version {}; version 2 is read", name_, version);
    std::size_t position = 12;
    while (bytes.size() - position >= 8) {
        const std::size_t length = load<std::uint32_t>(bytes.data() + position);
        const auto kind = load<std::uint32_t>(bytes.data() + position + 4);
        position += 8;
        if (length > bytes.size() - position)
            fail(ErrorCode::kInvalidInput,
                 "{}: byte {}: a chunk of {} bytes, but only {} are there: the file is cut off",
                 name_, position - 8, length, bytes.size() - position);
        const auto chunk = bytes.subspan(position, length);
        if (kind == kJsonChunk && json_.is_null()) parse(chunk);
        if (kind == kBinaryChunk && binary_.empty()) binary_ = chunk;
        position += length;
    }
}

GltfFile::Buffer GltfFile::read_uri(const std::string& uri) const {
    Buffer buffer;
    if (uri.starts_with("data:")) {
        const std::size_t comma = uri.find(',');
        auto decoded =
            comma == std::string::npos || uri.substr(0, comma).find(";base64") == std::string::npos
                ? std::nullopt
                : decode_base64(std::string_view(uri).substr(comma + 1));
        if (!decoded) fail(ErrorCode::kInvalidInput, "{}: a data URI that is not base64", name_);
        buffer.decoded = std::move(*decoded);
        buffer.bytes = buffer.decoded;
        return buffer;
    }
    buffer.mapped = std::make_unique<MappedFile>(folder_ / decode_percent(uri));
    buffer.bytes = buffer.mapped->bytes();
    return buffer;
}

const GltfFile::Json& GltfFile::entry(const char* key, std::size_t index) const {
    const auto array = json_.find(key);
    if (array == json_.end() || !array->is_array() || index >= array->size() ||
        !(*array)[index].is_object())
        fail(ErrorCode::kInvalidInput, "{}: there is no {}[{}]", name_, key, index);
    return (*array)[index];
}

std::optional<std::size_t> GltfFile::index(const Json& object, const char* key) const {
    const auto member = object.find(key);
    if (member == object.end()) return std::nullopt;
    if (!member->is_number_unsigned())
        fail(ErrorCode::kInvalidInput, "{}: '{}' is no non-negative integer", name_, key);
    return member->get<std::size_t>();
}

std::size_t GltfFile::index_or_fail(const Json& object, const char* key) const {
    const auto found = index(object, key);
    if (!found) fail(ErrorCode::kInvalidInput, "{}: member '{}' is missing", name_, key);
    return *found;
}

std::vector<double> GltfFile::numbers(const Json& object, const char* key, std::size_t size) const {
    const auto member = object.find(key);
    std::vector<double> out;
    if (member == object.end()) return out;
    if (member->is_array())
        for (const Json& number : *member)
            if (number.is_number()) out.push_back(number.get<double>());
    if (out.size() != size)
        fail(ErrorCode::kInvalidInput, "{}: '{}' does not hold {} numbers", name_, key, size);
    return out;
}

std::span<const std::byte> GltfFile::view(std::size_t index) const {
    const Json& json = entry("bufferViews", index);
    const std::size_t buffer = index_or_fail(json, "buffer");
    const std::size_t offset = this->index(json, "byteOffset").value_or(0);
    const std::size_t length = index_or_fail(json, "byteLength");
    if (buffer >= buffers_.size())
        fail(ErrorCode::kInvalidInput, "{}: there is no buffers[{}]", name_, buffer);
    const std::span<const std::byte> bytes = buffers_[buffer].bytes;
    if (offset > bytes.size() || length > bytes.size() - offset)
        fail(ErrorCode::kInvalidInput,
             "{}: bufferViews[{}] ends at byte {} of a buffer of {} bytes", name_, index,
             offset + length, bytes.size());
    return bytes.subspan(offset, length);
}

GltfValues GltfFile::accessor(std::size_t index) const {
    const Json& json = entry("accessors", index);
    if (json.contains("sparse") || !json.contains("bufferView"))
        fail(ErrorCode::kUnsupported, "{}: accessors[{}] is sparse, which is not read", name_,
             index);
    const std::size_t type = index_or_fail(json, "componentType");
    const std::size_t item = component_bytes(type);
    const auto type_name = json.find("type");
    const auto width = type_name != json.end() && type_name->is_string()
                           ? width_of(type_name->get_ref<const std::string&>())
                           : std::nullopt;
    if (item == 0 || !width)
        fail(ErrorCode::kInvalidInput, "{}: accessors[{}] has an unknown type", name_, index);
    GltfValues out;
    out.width = *width;
    out.count = index_or_fail(json, "count");
    const std::size_t view_index = index_or_fail(json, "bufferView");
    const std::span<const std::byte> bytes = view(view_index);
    const std::size_t offset = this->index(json, "byteOffset").value_or(0);
    const std::size_t stride =
        this->index(entry("bufferViews", view_index), "byteStride").value_or(item * out.width);
    const std::size_t size = item * out.width;
    if (stride < size || stride > 255 ||
        (out.count > 0 && (offset > bytes.size() || size > bytes.size() - offset ||
                           out.count - 1 > (bytes.size() - offset - size) / stride)))
        fail(ErrorCode::kInvalidInput,
             "{}: accessors[{}] promises {} elements, but its view has only {} bytes", name_, index,
             out.count, bytes.size());
    const auto normalized = json.find("normalized");
    const bool is_normalized =
        normalized != json.end() && normalized->is_boolean() && normalized->get<bool>();
    const double scale = is_normalized ? component_max(type) : 1.0;
    out.values.reserve(out.count * out.width);
    for (std::size_t i = 0; i < out.count; ++i)
        for (std::size_t k = 0; k < out.width; ++k)
            out.values.push_back(std::max(
                load_component(type, bytes.data() + offset + i * stride + k * item) / scale,
                is_normalized ? -1.0 : -HUGE_VAL));
    return out;
}

Image GltfFile::image(std::size_t index) const {
    const Json& json = entry("images", index);
    const std::string what = fmt::format("{}: images[{}]", name_, index);
    if (const auto uri = json.find("uri"); uri != json.end() && uri->is_string())
        return decode_image(read_uri(uri->get_ref<const std::string&>()).bytes, what);
    return decode_image(view(index_or_fail(json, "bufferView")), what);
}

}  // namespace pointbake
