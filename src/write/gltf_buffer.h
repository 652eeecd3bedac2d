// The binary buffer of a glTF: what lies where, and who writes it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/atomic_file.h"
#include "core/parallel.h"
#include "write/meshopt_coding.h"

namespace pointbake {

/// JSON whose keys keep the order they were added in: the same bytes on every run.
using Json = nlohmann::ordered_json;

/// The next multiple of four.
constexpr std::uint64_t aligned(std::uint64_t num_bytes) { return (num_bytes + 3) / 4 * 4; }

/// Fills up to the next multiple of four.
inline void write_padding(AtomicFile& file, std::uint64_t num_bytes, char fill) {
    file.write(std::string(static_cast<std::size_t>(aligned(num_bytes) - num_bytes), fill));
}

/// Buffer views and accessors, each with its own view; the values are asked for while the buffer is
/// written, or at once where they are compressed.
class GltfBuffer {
 public:
    GltfBuffer(const Context& context, bool has_meshopt)
        : context_(context), has_meshopt_(has_meshopt) {}

    /// Bytes of another format (an image), which must live until write().
    std::size_t add_bytes(std::span<const std::byte> bytes) {
        return add_view(bytes.size(), 0, [bytes](AtomicFile& file) { file.write(bytes); });
    }

    /// An accessor without a view: what it holds is told elsewhere.
    std::size_t add_empty_accessor(Json accessor, std::size_t count) {
        accessor["count"] = count;
        accessors_.push_back(std::move(accessor));
        return accessors_.size() - 1;
    }

    /// Triangles' indices, as 16 bits (T) or 32.
    template <class T>
    std::size_t add_indices(Json accessor, int target, const std::vector<Index>& indices) {
        if (has_meshopt_)
            return add_meshopt(std::move(accessor), target, indices.size(), sizeof(T),
                               meshopt_indices(indices));
        return add_accessor<T>(std::move(accessor), target, indices.size(),
                               [&indices](std::size_t i) { return static_cast<T>(indices[i]); });
    }

    /// An accessor of `count` elements value(0), value(1), ... of type T; `accessor` holds its
    /// componentType, type and whatever else it needs. Compressed floats become multiples of
    /// 2^exponent. Returns its index.
    template <class T, class Value>
    std::size_t add_attribute(Json accessor, int target, std::size_t count,
                              std::optional<int> exponent, Value value) {
        if (!has_meshopt_) return add_accessor<T>(std::move(accessor), target, count, value);
        std::vector<T> elements;
        for (std::size_t i = 0; i < count; ++i) elements.push_back(value(i));
        check_cancelled(context_);
        return add_meshopt(
            std::move(accessor), target, count, sizeof(T),
            meshopt_attribute(std::as_bytes(std::span<const T>(elements)), sizeof(T), exponent));
    }

    void write(AtomicFile& file) const {
        for (const Block& block : blocks_) {
            check_cancelled(context_);
            block.write(file);
            write_padding(file, block.num_bytes, '\0');
        }
    }

    std::uint64_t num_bytes() const { return num_bytes_; }
    /// Of what a decoder unpacks.
    std::uint64_t num_unpacked_bytes() const { return num_unpacked_bytes_; }
    const Json& views() const { return views_; }
    const Json& accessors() const { return accessors_; }

 private:
    static constexpr std::size_t kElementsPerPoll = std::size_t{1} << 16;

    struct Block {
        std::uint64_t num_bytes = 0;
        std::function<void(AtomicFile&)> write;
    };

    template <class T, class Value>
    std::size_t add_accessor(Json accessor, int target, std::size_t count, Value value) {
        const auto write = [count, value, &context = context_](AtomicFile& file) {
            std::vector<T> chunk;
            for (std::size_t begin = 0; begin < count; begin += kElementsPerPoll) {
                check_cancelled(context);
                chunk.clear();
                const std::size_t end = std::min(count, begin + kElementsPerPoll);
                for (std::size_t i = begin; i < end; ++i) chunk.push_back(value(i));
                file.write(std::as_bytes(std::span<const T>(chunk)));
            }
        };
        Json json = {{"bufferView", add_view(count * sizeof(T), target, write)}};
        json.update(accessor);
        return add_empty_accessor(std::move(json), count);
    }

    /// A view of the second buffer, which is nowhere: a decoder unpacks it.
    std::size_t add_meshopt(Json accessor, int target, std::size_t count, std::size_t stride,
                            MeshoptView packed) {
        const std::uint64_t offset = num_bytes_, num_packed = packed.bytes.size();
        add_block(num_packed,
                  [bytes = std::move(packed.bytes)](AtomicFile& file) { file.write(bytes); });
        Json view = {
            {"buffer", 1}, {"byteOffset", num_unpacked_bytes_}, {"byteLength", count * stride}};
        if (packed.mode == "ATTRIBUTES") view["byteStride"] = stride;
        view["target"] = target;
        view["extensions"]["EXT_meshopt_compression"] = {{"buffer", 0},
                                                         {"byteOffset", offset},
                                                         {"byteLength", num_packed},
                                                         {"byteStride", stride},
                                                         {"count", count},
                                                         {"mode", packed.mode},
                                                         {"filter", packed.filter}};
        views_.push_back(std::move(view));
        num_unpacked_bytes_ += aligned(count * stride);
        Json json = {{"bufferView", views_.size() - 1}};
        json.update(accessor);
        return add_empty_accessor(std::move(json), count);
    }

    void add_block(std::uint64_t num_bytes, std::function<void(AtomicFile&)> write) {
        blocks_.push_back({num_bytes, std::move(write)});
        num_bytes_ += aligned(num_bytes);
    }

    /// target: what OpenGL binds it as; 0 = nothing.
    std::size_t add_view(std::uint64_t num_bytes, int target,
                         std::function<void(AtomicFile&)> write) {
        Json view = {{"buffer", 0}, {"byteOffset", num_bytes_}, {"byteLength", num_bytes}};
        if (target != 0) view["target"] = target;
        views_.push_back(std::move(view));
        add_block(num_bytes, std::move(write));
        return views_.size() - 1;
    }

    const Context& context_;
    bool has_meshopt_;
    Json views_ = Json::array(), accessors_ = Json::array();
    std::vector<Block> blocks_;
    std::uint64_t num_bytes_ = 0, num_unpacked_bytes_ = 0;
};

}  // namespace pointbake
