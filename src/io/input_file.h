// The bytes of an input, wherever they come from: a file, mapped; gzip or zstd, unpacked; standard
// input, read to its end.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "core/mapped_file.h"
#include "pointbake/context.h"

namespace pointbake {

/// Bytes that grow without being copied or cleared where the system can help it.
class ByteBuffer {
 public:
    /// Room for at least `room` more bytes, after those that are there. Throws std::bad_alloc.
    std::span<std::byte> grow(std::size_t room);
    void add(std::size_t num_written) { size_ += num_written; }
    std::span<const std::byte> bytes() const { return {data_.get(), size_}; }

 private:
    struct Free {
        void operator()(std::byte* p) const { std::free(p); }
    };
    std::unique_ptr<std::byte, Free> data_;
    std::size_t size_ = 0, capacity_ = 0;
};

class InputFile {
 public:
    /// "-" is standard input. Throws Error{kIo}, Error{kInvalidInput} for damaged compressed data,
    /// Error{kLimit} for such that unpacks to far more than any cloud does.
    InputFile(const std::filesystem::path& path, const Context& context);

    std::span<const std::byte> bytes() const { return bytes_; }

 private:
    std::optional<MappedFile> file_;
    ByteBuffer buffer_;
    std::span<const std::byte> bytes_;
};

/// Whether the bytes begin like gzip or zstd.
bool is_gzip(std::span<const std::byte> bytes);
bool is_zstd(std::span<const std::byte> bytes);

/// Unpacks all members or frames, one after the other. The output's claimed size is not looked at.
/// Throws Error{kInvalidInput, kLimit} naming `name`.
ByteBuffer unpack_gzip(std::span<const std::byte> bytes, const std::string& name,
                       const Context& context);
ByteBuffer unpack_zstd(std::span<const std::byte> bytes, const std::string& name,
                       const Context& context);

/// ".xyz" of "A/b.XYZ" and of "b.xyz.gz".
std::string kind_extension(const std::filesystem::path& path);

}  // namespace pointbake
