// rename(2) replaces the target in one step. Devices and pipes cannot be replaced: they are
// written directly.
#include "core/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <string>
#include <system_error>
#include <vector>

#include "core/message.h"

namespace pointbake {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kBufferBytes = std::size_t{1} << 20;
constexpr int kNameAttempts = 1000;  // temporary names that may be taken by leftovers of others

/// What to do about an error of the system; empty if the reason says it all.
std::string_view advice(int error) {
    switch (error) {
        case ENOSPC:
        case EDQUOT:
        case EFBIG:
            return ": free some space, or write to another disk";
        case EACCES:
        case EPERM:
            return ": change the permissions, or write to another folder";
        case EROFS:
            return ": write to another folder";
        case ENAMETOOLONG:
            return ": give a shorter name";
        default:
            return "";
    }
}

[[noreturn]] void fail_output(const fs::path& path, int error) {
    fail(ErrorCode::kOutput, "cannot write '{}': {}{}", path.string(),
         std::generic_category().message(error), advice(error));
}

/// The folder that a file lies in; "." for a bare name.
fs::path folder_of(const fs::path& path) {
    return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

void check_folder(const fs::path& target) {
    const fs::path folder = folder_of(target);
    std::error_code error;
    const fs::file_status status = fs::status(folder, error);
    if (!fs::exists(status)) {
        if (error && error != std::errc::no_such_file_or_directory)
            fail_output(target, error.value());
        fail(ErrorCode::kOutput, "cannot write '{}': the folder '{}' does not exist: create it",
             target.string(), folder.string());
    }
    if (!fs::is_directory(status))
        fail(ErrorCode::kOutput, "cannot write '{}': '{}' is not a folder", target.string(),
             folder.string());
}

}  // namespace

struct AtomicFile::Impl {
    fs::path target;     // as given, for messages
    fs::path temporary;  // empty if the target is written directly
    fs::path renamed;    // the target with symbolic links followed
    int file = -1;
    bool is_committed = false;
    bool holds_old = false;  // the temporary file is what the target was
    std::vector<std::byte> buffer;

    ~Impl() {
        if (file >= 0) ::close(file);
        if (!temporary.empty()) ::unlink(temporary.c_str());
    }

    void open_target();
    void open_temporary();
    void write_out(std::span<const std::byte> bytes);
    void flush() {
        write_out(buffer);
        buffer.clear();
    }
    void put_in_place();
};

void AtomicFile::Impl::open_target() {
    if (target.filename().empty())
        fail(ErrorCode::kOutput, "cannot write '{}': it names a folder: give a file name",
             target.string());
    check_folder(target);
    std::error_code error;
    const fs::file_status status = fs::status(target, error);
    if (fs::is_directory(status))
        fail(ErrorCode::kOutput, "cannot write '{}': it is a folder: give a file name",
             target.string());
    if (fs::exists(status) && ::access(target.c_str(), W_OK) != 0) fail_output(target, errno);
    if (fs::exists(status) && !fs::is_regular_file(status)) {
        file = ::open(target.c_str(), O_WRONLY | O_CLOEXEC);
        if (file < 0) fail_output(target, errno);
        return;
    }
    renamed = fs::is_symlink(fs::symlink_status(target, error))
                  ? fs::weakly_canonical(target, error)
                  : target;
    if (renamed.empty()) renamed = target;
    open_temporary();
    // A private file stays private.
    if (fs::exists(status)) ::fchmod(file, static_cast<mode_t>(status.permissions()));
}

void AtomicFile::Impl::open_temporary() {
    for (int attempt = 0; attempt < kNameAttempts; ++attempt) {
        const fs::path name =
            folder_of(renamed) / fmt::format(".pointbake-{}-{}.tmp", ::getpid(), attempt);
        file = ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (file >= 0) {
            temporary = name;
            return;
        }
        if (errno != EEXIST) fail_output(target, errno);
    }
    fail_output(target, EEXIST);
}

void AtomicFile::Impl::write_out(std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
        const ssize_t written = ::write(file, bytes.data(), bytes.size());
        if (written < 0) {
            if (errno == EINTR) continue;
            fail_output(target, errno);
        }
        bytes = bytes.subspan(static_cast<std::size_t>(written));
    }
}

/// The old target takes the temporary name, so that commit() can be undone; where there is none, or
/// the file system cannot exchange names, it is replaced.
void AtomicFile::Impl::put_in_place() {
    const auto rename_with = [&](unsigned flags) {
        return ::renameat2(AT_FDCWD, temporary.c_str(), AT_FDCWD, renamed.c_str(), flags) == 0;
    };
    holds_old = rename_with(RENAME_EXCHANGE);
    if (!holds_old && ::rename(temporary.c_str(), renamed.c_str()) != 0) fail_output(target, errno);
    is_committed = true;
    if (!holds_old) temporary.clear();
}

AtomicFile::AtomicFile(fs::path target) : impl_(std::make_unique<Impl>()) {
    impl_->target = std::move(target);
    impl_->buffer.reserve(kBufferBytes);
    impl_->open_target();
}

AtomicFile::~AtomicFile() = default;

void AtomicFile::write(std::span<const std::byte> bytes) {
    if (impl_->buffer.size() + bytes.size() > kBufferBytes) impl_->flush();
    if (bytes.size() >= kBufferBytes)
        impl_->write_out(bytes);
    else
        impl_->buffer.insert(impl_->buffer.end(), bytes.begin(), bytes.end());
    size_ += bytes.size();
}

void AtomicFile::write(std::string_view text) {
    write(std::as_bytes(std::span<const char>(text.data(), text.size())));
}

void AtomicFile::commit() {
    impl_->flush();
    // Some file systems tell of a full disk only here.
    const int closed = ::close(impl_->file);
    impl_->file = -1;
    if (closed != 0 && errno != EINTR) fail_output(impl_->target, errno);
    if (!impl_->temporary.empty()) impl_->put_in_place();
}

void AtomicFile::undo() noexcept {
    if (!impl_->is_committed) return;
    if (impl_->holds_old)
        ::rename(impl_->temporary.c_str(), impl_->renamed.c_str());
    else
        ::unlink(impl_->renamed.c_str());
    impl_->temporary.clear();
}

void check_is_no_stranger(const std::filesystem::path& main, const std::filesystem::path& part) {
    std::error_code error;
    if (!std::filesystem::exists(main, error) && std::filesystem::exists(part, error))
        fail(ErrorCode::kOutput,
             "{} is there already and would be overwritten as a part of {}: choose another name",
             part.string(), main.string());
}

}  // namespace pointbake
