// The stream is a row of tokens. A first byte c below 32: c + 1 bytes follow as they are. Else a
// repetition: its length is c >> 5, or if that is 7 then 7 + the next byte, plus 2 in either case;
// how far back it begins is (c & 31) * 256 + the next byte, plus 1.
#include "io/lzf.h"

#include <algorithm>
#include <cstring>

namespace pointbake {

bool unpack_lzf(std::span<const std::byte> in, std::span<std::byte> out) {
    std::size_t from = 0, to = 0;
    const auto left = [&] { return in.size() - from; };
    const auto next = [&] { return std::to_integer<std::size_t>(in[from++]); };
    while (from < in.size()) {
        const std::size_t control = next();
        if (control < 32) {
            const std::size_t size = control + 1;
            if (size > left() || size > out.size() - to) return false;
            std::memcpy(out.data() + to, in.data() + from, size);
            from += size;
            to += size;
            continue;
        }
        std::size_t size = control >> 5;
        if (left() < (size == 7 ? 2U : 1U)) return false;
        if (size == 7) size += next();
        size += 2;
        const std::size_t back = (control & 31U) * 256 + next() + 1;
        if (back > to || size > out.size() - to) return false;
        // Byte by byte where what is copied overlaps what it makes.
        if (back >= size) {
            std::memcpy(out.data() + to, out.data() + to - back, size);
            to += size;
        } else {
            for (const std::size_t end = to + size; to < end; ++to) out[to] = out[to - back];
        }
    }
    return to == out.size();
}

}  // namespace pointbake
