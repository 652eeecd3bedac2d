// A ZIP archive whose files are stored as they are, each at a multiple of 64 bytes: what USDZ asks
// for.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "core/atomic_file.h"

namespace pointbake {

class StoredZip {
 public:
    /// A file in the archive; the bytes must live until write().
    void add(std::string name, std::span<const std::byte> bytes);
    /// Throws Error{kLimit} beyond 4 GiB, which is the format's end.
    void write(AtomicFile& file) const;

 private:
    struct Entry {
        std::string name;
        std::span<const std::byte> bytes;
    };
    std::vector<Entry> entries_;
};

}  // namespace pointbake
