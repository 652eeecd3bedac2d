#include "targets.h"

#include <array>
#include <string>
#include <vector>

#include "core/message.h"
#include "io/e57_pages.h"
#include "io/image_io.h"
#include "io/input_file.h"
#include "io/number_type.h"
#include "io/read_e57.h"
#include "io/read_gltf.h"
#include "io/read_las.h"
#include "io/read_obj.h"
#include "io/read_off.h"
#include "io/read_pcd.h"
#include "io/read_ply.h"
#include "io/read_ptx.h"
#include "io/read_splats.h"
#include "io/read_stl.h"
#include "io/read_text.h"
#include "options_target.h"

namespace pointbake::fuzz {
namespace {

using Bytes = std::span<const std::byte>;

// Threads would make runs differ.
const Context kContext{.threads = 1};

std::string_view as_text(Bytes bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

void run_text(Bytes bytes) {
    for (const char* path : {"fuzz.xyz", "fuzz.pts", "fuzz.pwn"})
        if (const auto layout = find_text_layout(as_text(bytes), path))
            read_text(as_text(bytes), *layout, path, {}, kContext);
}

/// Checksums of pages are made right, else nothing behind them would be reached.
void run_e57(Bytes bytes) {
    constexpr std::size_t kPage = 1024, kInPage = kPage - 4;
    std::vector<std::byte> pages(bytes.begin(), bytes.end());
    for (std::size_t at = 0; at + kPage <= pages.size(); at += kPage) {
        const std::uint32_t crc = crc32c(Bytes(pages).subspan(at, kInPage));
        for (std::size_t k = 0; k < 4; ++k)
            pages[at + kInPage + k] = static_cast<std::byte>(crc >> (24 - 8 * k));
    }
    read_e57(pages, "fuzz.e57", kContext);
}

constexpr std::array kTargets = {
    Target{"ply", [](Bytes b) { read_ply_cloud(b, "fuzz.ply", kContext); }},
    Target{"ply_mesh", [](Bytes b) { read_ply_mesh(b, "fuzz.ply", kContext); }},
    Target{"pcd", [](Bytes b) { read_pcd(b, "fuzz.pcd", kContext); }},
    Target{"text", run_text},
    Target{"ptx", [](Bytes b) { read_ptx(as_text(b), "fuzz.ptx", kContext); }},
    Target{"las", [](Bytes b) { read_las(b, "fuzz.las", kContext); }},
    Target{"laz", [](Bytes b) { read_las(b, "fuzz.laz", kContext); }},
    Target{"e57", run_e57},
    Target{"obj", [](Bytes b) { read_obj(b, "fuzz.obj", kContext); }},
    Target{"off", [](Bytes b) { read_off(as_text(b), "fuzz.off", kContext); }},
    Target{"stl", [](Bytes b) { read_stl(b, "fuzz.stl", kContext); }},
    Target{"gltf", [](Bytes b) { read_gltf(b, "fuzz.gltf", kContext); }},
    Target{"splat", [](Bytes b) { read_splat(b, "fuzz.splat", kContext); }},
    Target{"spz", [](Bytes b) { read_spz(b, "fuzz.spz", kContext); }},
    Target{"gzip", [](Bytes b) { unpack_gzip(b, "fuzz.gz", kContext); }},
    Target{"zstd", [](Bytes b) { unpack_zstd(b, "fuzz.zst", kContext); }},
    Target{"image", [](Bytes b) { decode_image(b, "fuzz.png"); }},
    Target{"options", run_options},
};

}  // namespace

std::span<const Target> targets() { return kTargets; }

}  // namespace pointbake::fuzz
