// A file's bytes, mapped read-only.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

namespace pointbake {

/// Throws Error{kIo} naming the path and the reason (missing, a directory, no permission, empty is
/// allowed).
class MappedFile {
 public:
    explicit MappedFile(const std::filesystem::path& path);
    ~MappedFile();
    MappedFile(const MappedFile&) = delete;
    MappedFile& operator=(const MappedFile&) = delete;

    std::span<const std::byte> bytes() const { return {data_, size_}; }

    /// What was opened, if a mapped file lies at this address, else nullptr. May be called by a
    /// signal handler: bytes that cannot be read are a SIGBUS.
    static const char* name_at(const void* address);

 private:
    std::string name_;
    const std::byte* data_ = nullptr;
    std::size_t size_ = 0;
};

}  // namespace pointbake
