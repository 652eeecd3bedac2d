// The binary buffer of a glTF: what lies where, and who writes it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "core/atomic_file.h"
#include "core/parallel.h"

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
/// written.
class GltfBuffer {
 public:
    explicit GltfBuffer(const Context& context) : context_(context) {}

    /// Bytes of another format (an image), which must live until write().
    std::size_t add_bytes(std::span<const std::byte> bytes) {
        return add_view(bytes.size(), 0, [bytes](AtomicFile& file) { file.write(bytes); });
    }

    /// An accessor of `count` elements value(0), value(1), ... of type T; `accessor` holds its
    /// componentType, type and whatever else it needs. Returns its index.
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
        json["count"] = count;
        accessors_.push_back(std::move(json));
        return accessors_.size() - 1;
    }

    void write(AtomicFile& file) const {
        for (const Block& block : blocks_) {
            check_cancelled(context_);
            block.write(file);
            write_padding(file, block.num_bytes, '\0');
        }
    }

    std::uint64_t num_bytes() const { return num_bytes_; }
    const Json& views() const { return views_; }
    const Json& accessors() const { return accessors_; }

 private:
    static constexpr std::size_t kElementsPerPoll = std::size_t{1} << 16;

    struct Block {
        std::uint64_t num_bytes = 0;
        std::function<void(AtomicFile&)> write;
    };

    /// target: what OpenGL binds it as; 0 = nothing.
    std::size_t add_view(std::uint64_t num_bytes, int target,
                         std::function<void(AtomicFile&)> write) {
        Json view = {{"buffer", 0}, {"byteOffset", num_bytes_}, {"byteLength", num_bytes}};
        if (target != 0) view["target"] = target;
        views_.push_back(std::move(view));
        blocks_.push_back({num_bytes, std::move(write)});
        num_bytes_ += aligned(num_bytes);
        return blocks_.size() - 1;
    }

    const Context& context_;
    Json views_ = Json::array(), accessors_ = Json::array();
    std::vector<Block> blocks_;
    std::uint64_t num_bytes_ = 0;
};

}  // namespace pointbake
