// A glTF 2.0 file with its buffers: JSON, typed values, images.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/mapped_file.h"
#include "pointbake/types.h"

namespace pointbake {

/// An accessor's values, as doubles; normalised ones in [0, 1] or [-1, 1].
struct GltfValues {
    std::size_t count = 0;
    std::size_t width = 0;  ///< components per element
    std::vector<double> values;

    double at(std::size_t element, std::size_t component) const {
        return values[element * width + component];
    }
};

/// Every access is checked; what does not fit throws Error{kInvalidInput} naming the file and the
/// place.
class GltfFile {
 public:
    using Json = nlohmann::json;

    /// GLB or JSON text, told apart by content.
    GltfFile(std::span<const std::byte> bytes, const std::filesystem::path& path);

    const Json& json() const { return json_; }
    const std::string& name() const { return name_; }

    /// Entry `index` of the top-level array `key`.
    const Json& entry(const char* key, std::size_t index) const;
    /// A non-negative integer member.
    std::optional<std::size_t> index(const Json& object, const char* key) const;
    std::size_t index_or_fail(const Json& object, const char* key) const;
    /// An array of numbers of this size; empty if there is no such member.
    std::vector<double> numbers(const Json& object, const char* key, std::size_t size) const;

    GltfValues accessor(std::size_t index) const;
    Image image(std::size_t index) const;

 private:
    struct Buffer {
        std::vector<std::byte> decoded;      ///< from a data URI
        std::unique_ptr<MappedFile> mapped;  ///< of a file
        std::span<const std::byte> bytes;
    };

    void read_container(std::span<const std::byte> bytes);
    Buffer read_uri(const std::string& uri) const;
    std::span<const std::byte> view(std::size_t index) const;

    std::filesystem::path folder_;
    std::string name_;
    Json json_;
    std::span<const std::byte> binary_;  ///< the GLB's own chunk
    std::vector<Buffer> buffers_;
};

}  // namespace pointbake
