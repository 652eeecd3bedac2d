// Preloaded into the program: makes one call of the system fail. FAULT is "CALL N ERRNO", for the
// N-th such call on the files that count: those opened for writing, or for "read", "map" and
// "truncate" the input. "vanish" removes the folder FAULT_FOLDER before a file is made. The file
// FAULT_LOG is made when it strikes.
#include <dlfcn.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdarg>

namespace {

template <class Call>
Call* next(const char* name) {
    return reinterpret_cast<Call*>(dlsym(RTLD_NEXT, name));
}

/// Whether this call is the one that shall fail; errno is set then.
bool strikes(const char* call) {
    static int count = 0;
    char wanted[32] = "";
    int number = 0, error = 0;
    const char* const fault = getenv("FAULT");
    if (fault == nullptr || sscanf(fault, "%31s %d %d", wanted, &number, &error) != 3) return false;
    if (strcmp(call, wanted) != 0 || ++count != number) return false;
    const int log =
        next<int(const char*, int, ...)>("open")(getenv("FAULT_LOG"), O_WRONLY | O_CREAT, 0600);
    next<int(int)>("close")(log);
    errno = error;
    return true;
}

bool is_output(int file) {
    struct stat status{};
    return file > STDERR_FILENO && fstat(file, &status) == 0 && S_ISREG(status.st_mode) &&
           (fcntl(file, F_GETFL) & O_ACCMODE) != O_RDONLY;
}

// Exchanging names is tried first, then replacing one: both fail.
bool fails_to_exchange = false;

bool is_for_writing(int flags) { return (flags & O_CREAT) != 0; }

}  // namespace

extern "C" {

ssize_t write(int file, const void* bytes, size_t size) {
    if (is_output(file) && strikes("write")) return -1;
    return next<ssize_t(int, const void*, size_t)>("write")(file, bytes, size);
}

int open(const char* path, int flags, ...) {
    va_list more;
    va_start(more, flags);
    const int mode = is_for_writing(flags) ? va_arg(more, int) : 0;
    va_end(more);
    if (is_for_writing(flags) && strikes("open")) return -1;
    if (!is_for_writing(flags) && strstr(path, "in.ply") != nullptr && strikes("read")) return -1;
    if (is_for_writing(flags) && strikes("vanish")) {
        const char* const folder = getenv("FAULT_FOLDER");
        char gone[4096];
        snprintf(gone, sizeof gone, "%s.gone", folder);
        next<int(const char*, const char*)>("rename")(folder, gone);
    }
    return next<int(const char*, int, ...)>("open")(path, flags, mode);
}

int close(int file) {
    struct stat status{};
    // A file that nothing was written to is only a question whether it could be.
    const bool is_written = is_output(file) && fstat(file, &status) == 0 && status.st_size > 0;
    const bool fails = is_written && strikes("close");
    const int error = errno;
    const int result = next<int(int)>("close")(file);
    errno = error;
    return fails ? -1 : result;
}

int rename(const char* from, const char* to) {
    if (fails_to_exchange) {
        fails_to_exchange = false;
        errno = EROFS;
        return -1;
    }
    return next<int(const char*, const char*)>("rename")(from, to);
}

int renameat2(int from_folder, const char* from, int to_folder, const char* to, unsigned flags) {
    if (strikes("rename")) {
        fails_to_exchange = true;
        return -1;
    }
    return next<int(int, const char*, int, const char*, unsigned)>("renameat2")(
        from_folder, from, to_folder, to, flags);
}

void* mmap(void* at, size_t size, int protection, int flags, int file, off_t offset) {
    const auto real = next<void*(void*, size_t, int, int, int, off_t)>("mmap");
    const bool is_input = file > STDERR_FILENO && protection == PROT_READ;
    if (is_input && strikes("map")) return MAP_FAILED;
    // What a file that has become empty meanwhile looks like: its pages are there and cannot be
    // read.
    if (is_input && strikes("truncate")) file = memfd_create("empty", 0);
    return real(at, size, protection, flags, file, offset);
}
}
