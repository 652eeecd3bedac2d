#include "core/memory.h"

#include <sys/resource.h>
#include <unistd.h>

#include <fstream>

namespace pointbake {

std::uint64_t peak_memory_bytes() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024U;
}

std::uint64_t memory_bytes() {
    std::ifstream file("/proc/self/statm");
    std::uint64_t virtual_pages = 0, resident_pages = 0, file_pages = 0;
    file >> virtual_pages >> resident_pages >> file_pages;
    return (resident_pages - file_pages) * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

}  // namespace pointbake
