// Output that is there whole or not at all: a temporary file beside the target, renamed by
// commit().
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string_view>

namespace pointbake {

/// Buffered. Every failing call throws Error{kOutput} naming the path and the reason (disk full, no
/// permission, ...). Without commit() the destructor removes the temporary file and the old target
/// stays as it was.
class AtomicFile {
 public:
    explicit AtomicFile(std::filesystem::path target);
    ~AtomicFile();
    AtomicFile(const AtomicFile&) = delete;
    AtomicFile& operator=(const AtomicFile&) = delete;

    void write(std::span<const std::byte> bytes);
    void write(std::string_view text);
    template <class T>
    void write_value(const T& value) {
        write(std::as_bytes(std::span<const T>(&value, 1)));
    }
    std::uint64_t size() const { return size_; }
    /// Puts the file in place of the target.
    void commit();
    /// After commit(): the target is again what it was, as far as the system allows.
    void undo() noexcept;

 private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
    std::uint64_t size_ = 0;
};

/// Throws Error{kOutput} if `part`, which goes with the output `main`, is there although `main` is
/// not: then it is somebody else's.
void check_is_no_stranger(const std::filesystem::path& main, const std::filesystem::path& part);

}  // namespace pointbake
