// PKWARE's APPNOTE 6.3: local headers with their files, the central directory, its end. Extra
// fields of local headers fill up to the next multiple of 64.
#include "write/stored_zip.h"

#include <libdeflate.h>

#include <cstdint>
#include <string_view>

#include "core/message.h"

namespace pointbake {
namespace {

constexpr std::uint64_t kAlignment = 64;
constexpr std::uint64_t kLocalHeaderBytes = 30, kExtraHeaderBytes = 4;
constexpr std::uint64_t kMaxBytes = ~std::uint32_t{0};
constexpr std::uint16_t kVersion = 10, kPaddingId = 0x1986;  // as USD's own tools mark it
constexpr std::uint16_t kFirstOfJanuary1980 = 0x21;

/// Little-endian numbers in a row.
class Record {
 public:
    Record& u16(std::uint64_t v) { return append(v, 2); }
    Record& u32(std::uint64_t v) { return append(v, 4); }
    Record& text(std::string_view v) {
        bytes_ += v;
        return *this;
    }
    const std::string& bytes() const { return bytes_; }

 private:
    Record& append(std::uint64_t v, int count) {
        for (int i = 0; i < count; ++i) bytes_ += static_cast<char>(v >> (8 * i));
        return *this;
    }
    std::string bytes_;
};

/// What local header and directory say alike, from the needed version to the name's length.
void append_facts(Record& record, const std::string& name, std::span<const std::byte> bytes) {
    const std::uint32_t crc = libdeflate_crc32(0, bytes.data(), bytes.size());
    constexpr int kNoFlags = 0, kStored = 0, kMidnight = 0;
    record.u16(kVersion).u16(kNoFlags).u16(kStored).u16(kMidnight).u16(kFirstOfJanuary1980);
    record.u32(crc).u32(bytes.size()).u32(bytes.size()).u16(name.size());
}

/// Bytes of the extra field that bring a file to its place.
std::uint64_t extra_bytes(std::uint64_t local_header, const std::string& name) {
    const std::uint64_t end = local_header + kLocalHeaderBytes + name.size();
    const std::uint64_t fill = (kAlignment - end % kAlignment) % kAlignment;
    return fill == 0 || fill >= kExtraHeaderBytes ? fill : fill + kAlignment;
}

}  // namespace

void StoredZip::add(std::string name, std::span<const std::byte> bytes) {
    entries_.push_back({std::move(name), bytes});
}

void StoredZip::write(AtomicFile& file) const {
    Record directory;
    for (const auto& [name, bytes] : entries_) {
        const std::uint64_t at = file.size();
        if (at + bytes.size() + kAlignment > kMaxBytes)
            fail(ErrorCode::kLimit, "a ZIP archive holds at most {} bytes: write .glb or .gltf",
                 kMaxBytes);
        const std::uint64_t extra = extra_bytes(at, name);
        Record local;
        append_facts(local.text("PK\x03\x04"), name, bytes);
        local.u16(extra).text(name);
        if (extra > 0)
            local.u16(kPaddingId)
                .u16(extra - kExtraHeaderBytes)
                .text(std::string(static_cast<std::size_t>(extra - kExtraHeaderBytes), '\0'));
        file.write(local.bytes());
        file.write(bytes);

        append_facts(directory.text("PK\x01\x02").u16(kVersion), name, bytes);
        directory.u16(0).u16(0).u16(0).u16(0).u32(0).u32(at).text(name);
    }
    Record end;
    end.text("PK\x05\x06").u16(0).u16(0).u16(entries_.size()).u16(entries_.size());
    end.u32(directory.bytes().size()).u32(file.size()).u16(0);
    file.write(directory.bytes());
    file.write(end.bytes());
}

}  // namespace pointbake
