// gzip (RFC 1952) through zlib, zstd (RFC 8878) through its library, both as streams.
#include "io/input_file.h"

#include <unistd.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <cerrno>
#include <limits>
#include <new>
#include <string_view>
#include <system_error>

#include "core/message.h"
#include "core/parallel.h"

namespace pointbake {
namespace {

constexpr std::size_t kStep = std::size_t{1} << 20;  // unpacked between two polls
// What begins with more than this from so few bytes is taken for a bomb: real tables of points
// shrink to a fiftieth at best, scans with many empty rows a little further.
constexpr std::size_t kSureUnpacked = std::size_t{1} << 25, kMostRatio = 200;

/// While unpacking: the bytes taken so far against what came of them.
void check_ratio(std::size_t num_unpacked, std::size_t num_taken, const std::string& name) {
    if (num_unpacked / kMostRatio <= num_taken || num_unpacked <= kSureUnpacked) return;
    fail(ErrorCode::kLimit,
         "{}: its first {} bytes unpack to {}: more than any cloud would; unpack it by hand", name,
         num_taken, num_unpacked);
}

/// Some writers pad with zeros.
bool is_padding(std::span<const std::byte> rest) {
    return std::all_of(rest.begin(), rest.end(), [](std::byte b) { return b == std::byte{}; });
}

/// Closes zlib's stream on every way out.
struct GzipStream {
    z_stream z{};
    GzipStream() {
        constexpr int kGzipOnly = 16;
        if (inflateInit2(&z, kGzipOnly + MAX_WBITS) != Z_OK) throw std::bad_alloc();
    }
    ~GzipStream() { inflateEnd(&z); }
    GzipStream(const GzipStream&) = delete;
    GzipStream& operator=(const GzipStream&) = delete;
};

ByteBuffer read_standard_input(const Context& context) {
    ByteBuffer buffer;
    for (;;) {
        check_cancelled(context);
        const std::span<std::byte> room = buffer.grow(kStep);
        const ssize_t n = ::read(STDIN_FILENO, room.data(), std::min(room.size(), kStep));
        if (n == 0) return buffer;
        if (n > 0)
            buffer.add(static_cast<std::size_t>(n));
        else if (errno != EINTR)
            fail(ErrorCode::kIo, "-: standard input cannot be read: {}",
                 std::generic_category().message(errno));
    }
}

}  // namespace

std::span<std::byte> ByteBuffer::grow(std::size_t room) {
    if (capacity_ - size_ < room) {
        const std::size_t wanted = std::max(size_ + room, capacity_ + capacity_ / 2);
        void* const grown = std::realloc(data_.get(), wanted);
        if (grown == nullptr) throw std::bad_alloc();
        static_cast<void>(data_.release());  // realloc has freed it
        data_.reset(static_cast<std::byte*>(grown));
        capacity_ = wanted;
    }
    return {data_.get() + size_, capacity_ - size_};
}

bool is_gzip(std::span<const std::byte> bytes) {
    return bytes.size() >= 3 && bytes[0] == std::byte{0x1f} && bytes[1] == std::byte{0x8b} &&
           bytes[2] == std::byte{8};
}

bool is_zstd(std::span<const std::byte> bytes) {
    return bytes.size() >= 4 && bytes[0] == std::byte{0x28} && bytes[1] == std::byte{0xb5} &&
           bytes[2] == std::byte{0x2f} && bytes[3] == std::byte{0xfd};
}

ByteBuffer unpack_gzip(std::span<const std::byte> bytes, const std::string& name,
                       const Context& context) {
    ByteBuffer out;
    GzipStream stream;
    z_stream& z = stream.z;
    std::size_t num_read = 0;
    for (;;) {
        check_cancelled(context);
        // zlib counts in 32 bits.
        const std::size_t num_given =
            std::min(bytes.size() - num_read, std::size_t{std::numeric_limits<unsigned>::max()});
        z.next_in = const_cast<Bytef*>(reinterpret_cast<const Bytef*>(bytes.data() + num_read));
        z.avail_in = static_cast<unsigned>(num_given);
        z.next_out = reinterpret_cast<Bytef*>(out.grow(kStep).data());
        z.avail_out = static_cast<unsigned>(kStep);
        const int status = inflate(&z, Z_NO_FLUSH);
        num_read += num_given - z.avail_in;
        out.add(kStep - z.avail_out);
        check_ratio(out.bytes().size(), num_read, name);
        if (status == Z_STREAM_END) {
            const std::span<const std::byte> rest = bytes.subspan(num_read);
            if (is_padding(rest)) return out;
            // gzip says so, too, and goes on.
            if (!is_gzip(rest)) {
                log(context, LogLevel::kWarning,
                    "{}: {} bytes behind the gzip data are none and ignored", name, rest.size());
                return out;
            }
            if (inflateReset(&z) != Z_OK) throw std::bad_alloc();
            continue;
        }
        if (status == Z_BUF_ERROR && num_read == bytes.size())
            fail(ErrorCode::kInvalidInput, "{}: the gzip data are cut off at byte {}", name,
                 bytes.size());
        if (status != Z_OK)
            fail(ErrorCode::kInvalidInput, "{}: byte {}: the gzip data are damaged ({})", name,
                 num_read, z.msg == nullptr ? "unknown" : z.msg);
    }
}

ByteBuffer unpack_zstd(std::span<const std::byte> bytes, const std::string& name,
                       const Context& context) {
    ByteBuffer out;
    const std::unique_ptr<ZSTD_DStream, std::size_t (*)(ZSTD_DStream*)> stream(ZSTD_createDStream(),
                                                                               ZSTD_freeDStream);
    if (!stream) throw std::bad_alloc();
    // Packed with --long, up to the largest window of the format.
    constexpr int kMostWindowLog = 31;
    ZSTD_DCtx_setParameter(stream.get(), ZSTD_d_windowLogMax, kMostWindowLog);
    ZSTD_inBuffer in{bytes.data(), bytes.size(), 0};
    for (;;) {
        check_cancelled(context);
        ZSTD_outBuffer step{out.grow(kStep).data(), kStep, 0};
        const std::size_t status = ZSTD_decompressStream(stream.get(), &step, &in);
        out.add(step.pos);
        check_ratio(out.bytes().size(), in.pos, name);
        if (ZSTD_isError(status))
            fail(ErrorCode::kInvalidInput, "{}: byte {}: the zstd data are damaged ({})", name,
                 in.pos, ZSTD_getErrorName(status));
        // 0: the frame has ended. A further call would ask for the next one's header.
        if (status == 0 && is_padding(bytes.subspan(in.pos))) return out;
        if (in.pos < in.size || step.pos == step.size) continue;
        fail(ErrorCode::kInvalidInput, "{}: the zstd data are cut off at byte {}", name,
             bytes.size());
    }
}

InputFile::InputFile(const std::filesystem::path& path, const Context& context) {
    const std::string name = path.string();
    if (path == "-") {
        buffer_ = read_standard_input(context);
        bytes_ = buffer_.bytes();
    } else {
        file_.emplace(path);
        bytes_ = file_->bytes();
    }
    if (!is_gzip(bytes_) && !is_zstd(bytes_)) return;
    buffer_ =
        is_gzip(bytes_) ? unpack_gzip(bytes_, name, context) : unpack_zstd(bytes_, name, context);
    bytes_ = buffer_.bytes();
    file_.reset();
    if (is_gzip(bytes_) || is_zstd(bytes_))
        fail(ErrorCode::kUnsupported, "{}: is packed twice; unpack it once by hand", name);
}

std::string kind_extension(const std::filesystem::path& path) {
    const auto lower = [](std::string text) {
        for (char& c : text)
            if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
        return text;
    };
    const std::string extension = lower(path.extension().string());
    if (extension != ".gz" && extension != ".zst") return extension;
    return lower(path.stem().extension().string());
}

}  // namespace pointbake
