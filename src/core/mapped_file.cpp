// POSIX mmap(2). The file must not shrink while it is mapped.
#include "core/mapped_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstdint>
#include <system_error>

#include "core/message.h"

namespace pointbake {
namespace {

[[noreturn]] void fail_input(const std::filesystem::path& path, int error) {
    fail(ErrorCode::kIo, "{}: cannot be read: {}", path.string(),
         std::generic_category().message(error));
}

// Those that are mapped now; a file for which no place is left has no name.
std::array<std::atomic<const MappedFile*>, 64> open_files{};

/// Closes the descriptor on every way out; the mapping outlives it.
struct Descriptor {
    int value;
    ~Descriptor() {
        if (value >= 0) ::close(value);
    }
};

}  // namespace

MappedFile::MappedFile(const std::filesystem::path& path) : name_(path.string()) {
    // O_NONBLOCK: opening a pipe without a writer must fail below, not wait.
    const Descriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)};
    if (file.value < 0) fail_input(path, errno);
    struct stat status{};
    if (::fstat(file.value, &status) != 0) fail_input(path, errno);
    if (S_ISDIR(status.st_mode))
        fail(ErrorCode::kIo, "{}: is a directory; a file is wanted", path.string());
    if (!S_ISREG(status.st_mode))
        fail(ErrorCode::kIo, "{}: is a pipe or device; a regular file is wanted", path.string());
    size_ = static_cast<std::size_t>(status.st_size);
    if (size_ == 0) return;
    void* mapping = ::mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, file.value, 0);
    if (mapping == MAP_FAILED) fail_input(path, errno);
    ::madvise(mapping, size_, MADV_WILLNEED);  // a hint: its failure changes nothing
    data_ = static_cast<const std::byte*>(mapping);
    for (auto& place : open_files) {
        const MappedFile* free = nullptr;
        if (place.compare_exchange_strong(free, this)) break;
    }
}

MappedFile::~MappedFile() {
    if (data_ == nullptr) return;
    for (auto& place : open_files) {
        const MappedFile* own = this;
        if (place.compare_exchange_strong(own, nullptr)) break;
    }
    ::munmap(const_cast<std::byte*>(data_), size_);
}

const char* MappedFile::name_at(const void* address) {
    const auto at = reinterpret_cast<std::uintptr_t>(address);
    for (const auto& place : open_files) {
        const MappedFile* const file = place;
        if (file == nullptr) continue;
        const auto begin = reinterpret_cast<std::uintptr_t>(file->data_);
        if (at >= begin && at - begin < file->size_) return file->name_.c_str();
    }
    return nullptr;
}

}  // namespace pointbake
