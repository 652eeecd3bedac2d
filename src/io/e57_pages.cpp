#include "io/e57_pages.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>

#include "core/message.h"
#include "core/parallel.h"
#include "io/number_type.h"

namespace pointbake {
namespace {

using Bytes = std::span<const std::byte>;

constexpr std::size_t kHeaderBytes = 48;
constexpr std::size_t kChecksumBytes = 4;
constexpr std::size_t kLeastPage = 64, kMostPage = 1 << 20;
constexpr std::size_t kPagesPerBlock = 1024;

constexpr std::array<std::uint32_t, 256> make_crc_table() {
    constexpr std::uint32_t kPolynomial = 0x82f63b78U;  // bits from last to first
    std::array<std::uint32_t, 256> table{};
    for (std::uint32_t i = 0; i < 256; ++i) {
        std::uint32_t rest = i;
        for (int bit = 0; bit < 8; ++bit)
            rest = (rest & 1U) != 0 ? rest >> 1 ^ kPolynomial : rest >> 1;
        table[i] = rest;
    }
    return table;
}

constexpr std::array<std::uint32_t, 256> kCrcTable = make_crc_table();

bool is_whole(Bytes page) {
    const std::size_t num_content = page.size() - kChecksumBytes;
    constexpr bool kSwap = std::endian::native == std::endian::little;  // it is big-endian
    return crc32c(page.first(num_content)) ==
           load_value<std::uint32_t>(page.data() + num_content, kSwap);
}

/// The number of bytes that the file should have, a multiple of the page size.
std::size_t check_length(Bytes bytes, std::size_t page_bytes, const std::string& name) {
    const auto promised = load_value<std::uint64_t>(bytes.data() + 16);
    if (promised > bytes.size())
        fail(ErrorCode::kInvalidInput,
             "{}: the header promises {} bytes, but the file ends at byte {}: it is cut off", name,
             promised, bytes.size());
    const std::size_t length =
        promised >= page_bytes ? static_cast<std::size_t>(promised) : bytes.size();
    if (length % page_bytes != 0)
        fail(ErrorCode::kInvalidInput,
             "{}: {} bytes are not a whole number of pages of {} bytes: the file is cut off, or "
             "its header is wrong",
             name, length, page_bytes);
    return length;
}

}  // namespace

std::uint32_t crc32c(Bytes bytes) {
    std::uint32_t crc = ~0U;
    for (const std::byte b : bytes)
        crc = crc >> 8 ^ kCrcTable[(crc ^ std::to_integer<std::uint32_t>(b)) & 255U];
    return ~crc;
}

std::size_t E57File::place(std::uint64_t byte_of_file) const {
    const std::size_t in_page = page_bytes - kChecksumBytes;
    const std::uint64_t page = byte_of_file / page_bytes, rest = byte_of_file % page_bytes;
    if (page >= content.size() / in_page || rest >= in_page) return content.size();
    return static_cast<std::size_t>(page) * in_page + static_cast<std::size_t>(rest);
}

E57File open_e57(Bytes bytes, const std::string& name, const Context& context) {
    if (bytes.size() < kHeaderBytes)
        fail(ErrorCode::kInvalidInput, "{}: the header is cut off at byte {}; it has {} bytes",
             name, bytes.size(), kHeaderBytes);
    const auto value = [&](std::size_t at) { return load_value<std::uint64_t>(bytes.data() + at); };
    const auto version = load_value<std::uint32_t>(bytes.data() + 8);
    if (version != 1)
        fail(ErrorCode::kUnsupported, "{}: E57 of version {}; 1 is read", name, version);
    const std::uint64_t page_bytes = value(40);
    if (page_bytes < kLeastPage || page_bytes > kMostPage)
        fail(ErrorCode::kInvalidInput, "{}: byte 40: pages of {} bytes; 1024 are usual", name,
             page_bytes);
    E57File file;
    file.page_bytes = static_cast<std::size_t>(page_bytes);
    const std::size_t in_page = file.page_bytes - kChecksumBytes;
    const std::size_t num_pages = check_length(bytes, file.page_bytes, name) / file.page_bytes;

    file.content.resize(num_pages * in_page);
    std::atomic<std::size_t> first_bad{num_pages};
    parallel_for(context, num_pages, kPagesPerBlock, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const Bytes page = bytes.subspan(i * file.page_bytes, file.page_bytes);
            std::memcpy(file.content.data() + i * in_page, page.data(), in_page);
            if (is_whole(page)) continue;
            std::size_t seen = first_bad;
            while (i < seen && !first_bad.compare_exchange_weak(seen, i)) {
            }
            return;
        }
    });
    if (first_bad < num_pages)
        fail(ErrorCode::kInvalidInput,
             "{}: page {} (byte {}) does not match its checksum: the file is damaged", name,
             first_bad.load(), first_bad * file.page_bytes);
    file.xml_at = file.place(value(24));
    file.xml_bytes = value(32);
    if (file.xml_bytes == 0 || file.xml_bytes > file.content.size() - file.xml_at)
        fail(ErrorCode::kInvalidInput,
             "{}: byte 24: the XML is said to be at byte {} and to have {} bytes; the file has {}",
             name, value(24), file.xml_bytes, bytes.size());
    return file;
}

}  // namespace pointbake
