// Input that is packed with gzip or zstd, damaged or far too large.
#include <zlib.h>
#include <zstd.h>

#include <span>

#include "io/input_file.h"
#include "io/test_files.h"

namespace pointbake::test {
namespace {

std::string gzip(const std::string& text) {
    z_stream z{};
    deflateInit2(&z, 9, Z_DEFLATED, 16 + MAX_WBITS, 8, Z_DEFAULT_STRATEGY);
    std::string out(deflateBound(&z, text.size()), '\0');
    z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
    z.avail_in = static_cast<unsigned>(text.size());
    z.next_out = reinterpret_cast<Bytef*>(out.data());
    z.avail_out = static_cast<unsigned>(out.size());
    deflate(&z, Z_FINISH);
    out.resize(z.total_out);
    deflateEnd(&z);
    return out;
}

std::string zstd(const std::string& text) {
    std::string out(ZSTD_compressBound(text.size()), '\0');
    out.resize(ZSTD_compress(out.data(), out.size(), text.data(), text.size(), 3));
    return out;
}

std::string many_lines(std::size_t n) {
    std::string text;
    for (std::size_t i = 0; i < n; ++i) text += std::to_string(i) + ".5 1 2\n";
    return text;
}

std::span<const std::byte> as_bytes(const std::string& text) {
    return std::as_bytes(std::span(text));
}

using Pack = std::string (*)(const std::string&);

TEST(Packed, EveryFormatReadsUnpacked) {
    const std::string ply = make_ply("binary_big_endian", {three_points()});
    for (const Pack pack : {Pack{gzip}, Pack{zstd}}) {
        EXPECT_EQ(load_as("a.ply.gz", pack(ply)).cloud.size(), 3U);
        EXPECT_EQ(load_as("a", pack(many_lines(1000))).cloud.size(), 1000U);
        // The name inside tells PTS.
        const std::string pts = "0.5 0 0 1 2 3 255\n1 1 1 4 5 6 255\n";
        EXPECT_NE(find_channel(load_as("a.pts.GZ", pack(pts)).cloud, "intensity"), nullptr);
        EXPECT_EQ(find_channel(load_as("a.xyz.gz", pack(pts)).cloud, "intensity"), nullptr);
        const TempFolder folder;
        const std::string obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
        EXPECT_EQ(load_mesh(folder.write("a.obj.zst", pack(obj))).mesh.triangles.size(), 1U);
    }
}

TEST(Packed, PartsFollowEachOther) {
    for (const Pack pack : {Pack{gzip}, Pack{zstd}})
        EXPECT_EQ(load_as("a.xyz", pack("0.5 1 2\n1 1 1\n") + pack("2 2 2\n")).cloud.size(), 3U);
    for (const Pack pack : {Pack{gzip}, Pack{zstd}})
        EXPECT_EQ(load_as("a.xyz", pack("0.5 1 2\n") + std::string(512, '\0')).cloud.size(), 1U);
}

TEST(Packed, MuchMoreThanAStepIsRead) {
    const std::string text = many_lines(400000);
    for (const Pack pack : {Pack{gzip}, Pack{zstd}})
        EXPECT_EQ(load_as("a.xyz", pack(text)).cloud.size(), 400000U);
}

TEST(Packed, WholeStepsAreNotCutOff) {
    constexpr std::size_t kStep = std::size_t{1} << 20;
    for (const std::size_t size : {kStep - 1, kStep, kStep + 1, 2 * kStep}) {
        SCOPED_TRACE(size);
        std::string text = "0.5 1 2\n1 1 1\n";
        text.resize(size, '\n');
        const std::string packed = zstd(text);
        EXPECT_EQ(unpack_zstd(as_bytes(packed), "a", {}).bytes().size(), size);
        for (const Pack pack : {Pack{gzip}, Pack{zstd}}) {
            EXPECT_EQ(load_as("a.xyz", pack(text)).cloud.size(), 2U);
            EXPECT_EQ(load_as("a.xyz", pack(text) + pack("2 2 2\n")).cloud.size(), 3U);
        }
    }
}

TEST(Packed, WhatFollowsGzipIsIgnoredWithAWarning) {
    std::string warning;
    const Context context{.log = [&](LogLevel, std::string_view text) { warning = text; }};
    EXPECT_EQ(load_as("a.xyz", gzip("0.5 1 2\n") + "garbage", {}, context).cloud.size(), 1U);
    EXPECT_NE(warning.find("7 bytes behind the gzip data"), std::string::npos) << warning;
}

TEST(Packed, TwiceIsTold) {
    for (const Pack outer : {Pack{gzip}, Pack{zstd}})
        for (const Pack inner : {Pack{gzip}, Pack{zstd}})
            expect_load_error("a.xyz.gz", outer(inner("0.5 1 2\n")), ErrorCode::kUnsupported,
                              "packed twice");
}

TEST(Packed, WideWindowsOfZstdAreRead) {
    const std::string text = many_lines(1000);
    ZSTD_CCtx* context = ZSTD_createCCtx();
    ZSTD_CCtx_setParameter(context, ZSTD_c_windowLog, 28);  // zstd --long=28
    ZSTD_CCtx_setParameter(context, ZSTD_c_contentSizeFlag, 0);
    std::string packed(ZSTD_compressBound(text.size()), '\0');
    ZSTD_inBuffer in{text.data(), text.size(), 0};
    ZSTD_outBuffer out{packed.data(), packed.size(), 0};
    ZSTD_compressStream2(context, &out, &in, ZSTD_e_flush);  // the size is not known yet
    ZSTD_compressStream2(context, &out, &in, ZSTD_e_end);
    ZSTD_freeCCtx(context);
    packed.resize(out.pos);
    EXPECT_EQ(load_as("a.xyz", packed).cloud.size(), 1000U);
}

TEST(Packed, EveryCutAndFlipIsAnErrorOrACloud) {
    const TempFolder folder;
    for (const Pack pack : {Pack{gzip}, Pack{zstd}}) {
        const std::string whole = pack(many_lines(40));
        for (std::size_t i = 0; i < whole.size(); ++i) {
            const Error error =
                error_of([&] { load_cloud(folder.write("a", whole.substr(0, i))); });
            EXPECT_FALSE(std::string(error.what()).empty());
            for (int flip : {1, 0x80, 0xff}) {
                std::string bytes = whole;
                bytes[i] = static_cast<char>(bytes[i] ^ flip);
                try {
                    EXPECT_LE(load_cloud(folder.write("a", bytes)).cloud.size(), 40U);
                } catch (const Error&) {
                }
            }
        }
        expect_load_error("a.gz", whole.substr(0, whole.size() - 3), ErrorCode::kInvalidInput,
                          "data are cut off at byte");
    }
    std::string bad = gzip(many_lines(4));
    bad[bad.size() - 6] ^= 1;
    expect_load_error("a.gz", bad, ErrorCode::kInvalidInput, "data are damaged (incorrect");
}

TEST(Packed, BombsAreRefused) {
    // 300 MB of zeros
    const std::size_t size = std::size_t{300} << 20;
    const std::string packed = [&] {
        const std::string part(std::size_t{50} << 20, '\0');
        std::string all;
        for (std::size_t i = 0; i < size / part.size(); ++i) all += zstd(part);
        return all;
    }();
    expect_load_error("a.zst", packed, ErrorCode::kLimit, "more than any cloud would");
}

}  // namespace
}  // namespace pointbake::test
