// E57 files are pages, each with a checksum at its end; what is in them is counted without those.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "pointbake/context.h"

namespace pointbake {

/// CRC-32C of Castagnoli [Castagnoli93].
std::uint32_t crc32c(std::span<const std::byte> bytes);

struct E57File {
    std::size_t page_bytes = 0;               ///< with the checksum
    std::vector<std::byte> content;           ///< all pages, without the checksums
    std::uint64_t xml_at = 0, xml_bytes = 0;  ///< in the content; inside of it

    /// Where in the content is what lies at this byte of the file; the content's size if nothing.
    std::size_t place(std::uint64_t byte_of_file) const;
};

/// Checks every page. Throws Error{kInvalidInput, kUnsupported} naming `name` and the page.
E57File open_e57(std::span<const std::byte> bytes, const std::string& name, const Context& context);

}  // namespace pointbake
