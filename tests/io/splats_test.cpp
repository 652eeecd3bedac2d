// Gaussian splats as surfels, from every format.
#include "io/splats.h"

#include <zlib.h>
#include <zstd.h>

#include "core/color.h"
#include "io/test_files.h"

namespace pointbake::test {
namespace {

constexpr double kHalf = 0.70710678118654752;

struct Splat {
    Vec3d position;
    Vec3d sigmas;
    std::array<double, 4> rotation{1, 0, 0, 0};  // w x y z
    double opacity = 0.9;
};

/// Four flat ones, the second turned by a quarter about y; then a faint one, a needle, a large one
/// and one that is not flat.
std::vector<Splat> splats() {
    return {{{0, 0, 0}, {0.2, 0.1, 0.01}},
            {{1, 0, 0}, {0.2, 0.1, 0.01}, {kHalf, 0, kHalf, 0}},
            {{0, 1, 0}, {0.01, 0.1, 0.2}},
            {{0, 0, 1}, {0.1, 0.1, 0.02}},
            {{2, 0, 0}, {0.2, 0.1, 0.01}, {1, 0, 0, 0}, 0.05},
            {{3, 0, 0}, {0.2, 0.005, 0.004}},
            {{4, 0, 0}, {3.0, 1.0, 0.01}},
            {{5, 0, 0}, {0.2, 0.1, 0.09}}};
}

std::vector<double> values(const std::vector<Splat>& all, auto&& value) {
    std::vector<double> out;
    for (const Splat& s : all) out.push_back(value(s));
    return out;
}

std::string splat_ply(const std::vector<Splat>& all, bool is_flat = false) {
    std::vector<TestProperty> p;
    const char* const axes[] = {"x", "y", "z"};
    for (std::size_t k = 0; k < 3; ++k)
        p.push_back(
            column("float", axes[k], values(all, [&](const Splat& s) { return s.position[k]; })));
    for (const char* name : {"nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2", "f_rest_0"})
        p.push_back(column("float", name, values(all, [](const Splat&) { return 0.0; })));
    p.push_back(column("float", "opacity", values(all, [](const Splat& s) {
                           return std::log(s.opacity / (1 - s.opacity));
                       })));
    for (std::size_t k = 0; k < (is_flat ? 2U : 3U); ++k)
        p.push_back(column("float", "scale_" + std::to_string(k),
                           values(all, [&](const Splat& s) { return std::log(s.sigmas[k]); })));
    for (std::size_t k = 0; k < 4; ++k)
        p.push_back(column("float", "rot_" + std::to_string(k),
                           values(all, [&](const Splat& s) { return s.rotation[k] * 3.0; })));
    return make_ply("binary_little_endian", {{"vertex", p}});
}

template <class T>
std::string raw(T value) {
    return {reinterpret_cast<const char*>(&value), sizeof value};
}

char byte_of(double value) {
    return static_cast<char>(static_cast<unsigned char>(std::clamp(std::round(value), 0.0, 255.0)));
}

std::string splat_file(const std::vector<Splat>& all) {
    std::string out;
    for (const Splat& s : all) {
        for (std::size_t k = 0; k < 3; ++k) out += raw(static_cast<float>(s.position[k]));
        for (std::size_t k = 0; k < 3; ++k) out += raw(static_cast<float>(s.sigmas[k]));
        out += std::string("\x80\x80\x80", 3) + byte_of(s.opacity * 255);
        for (const double q : s.rotation) out += byte_of(q * 128 + 128);
    }
    return out;
}

std::string smallest_three(const std::array<double, 4>& wxyz) {
    const std::array<double, 4> q{wxyz[1], wxyz[2], wxyz[3], wxyz[0]};
    std::size_t largest = 0;
    for (std::size_t k = 1; k < 4; ++k)
        if (std::abs(q[k]) > std::abs(q[largest])) largest = k;
    auto bits = static_cast<std::uint32_t>(largest);
    for (std::size_t k = 0; k < 4; ++k) {
        if (k == largest) continue;
        const double v = q[largest] < 0 ? -q[k] : q[k];
        bits = bits << 10 | (v < 0 ? 512U : 0U) |
               static_cast<std::uint32_t>(std::lround(std::abs(v) / kHalf * 511));
    }
    return raw(bits);
}

std::array<std::string, 5> spz_arrays(const std::vector<Splat>& all, int version) {
    std::array<std::string, 5> out;
    for (const Splat& s : all) {
        for (std::size_t k = 0; k < 3; ++k) {
            if (version == 1) {
                const auto whole = static_cast<int>(s.position[k]);  // 0 to 5: powers and sums
                constexpr std::uint16_t kHalves[] = {0, 0x3c00, 0x4000, 0x4200, 0x4400, 0x4500};
                out[0] += raw(kHalves[whole]);
            } else {
                out[0] +=
                    raw(static_cast<std::int32_t>(std::lround(s.position[k] * 4096))).substr(0, 3);
            }
            out[2] += '\x80';
            out[3] += byte_of((std::log(s.sigmas[k]) + 10) * 16);
        }
        out[1] += byte_of(s.opacity * 255);
        if (version >= 3)
            out[4] += smallest_three(s.rotation);
        else
            for (std::size_t k = 1; k < 4; ++k) out[4] += byte_of((s.rotation[k] + 1) * 127.5);
    }
    return out;
}

std::string zstd_of(const std::string& text) {
    std::string out(ZSTD_compressBound(text.size()), '\0');
    out.resize(ZSTD_compress(out.data(), out.size(), text.data(), text.size(), 3));
    return out;
}

std::string spz_file(const std::vector<Splat>& all, int version) {
    std::string out = "NGSP" + raw(version) + raw(static_cast<std::uint32_t>(all.size())) +
                      std::string("\0\x0c\0", 3);
    const std::array<std::string, 5> arrays = spz_arrays(all, version);
    if (version < 4) {
        out += '\0';
        for (const std::string& part : arrays) out += part;
        return out;
    }
    out += '\x05' + raw(std::uint32_t{32}) + std::string(12, '\0');
    std::string streams;
    for (const std::string& part : arrays) {
        const std::string packed = zstd_of(part);
        out += raw(std::uint64_t{packed.size()}) + raw(std::uint64_t{part.size()});
        streams += packed;
    }
    return out + streams;
}

TEST(Splats, StreamsOfWholeStepsAreRead) {
    // A stream of exactly 1 MiB, others of several
    const std::string bytes = spz_file(std::vector<Splat>(std::size_t{1} << 20), 4);
    EXPECT_EQ(load_as("a.spz", bytes).report.num_rows, std::size_t{1} << 20);
}

std::string packed_ply(const std::vector<Splat>& all) {
    // One chunk from (0, 0, 0) to (5, 5, 5), logs of sigmas from -6 to 2
    std::string out =
        "ply\nformat binary_little_endian 1.0\nelement chunk 1\n"
        "property float min_x\nproperty float min_y\nproperty float min_z\n"
        "property float max_x\nproperty float max_y\nproperty float max_z\n"
        "property float min_scale_x\nproperty float min_scale_y\nproperty float min_scale_z\n"
        "property float max_scale_x\nproperty float max_scale_y\nproperty float max_scale_z\n"
        "element vertex " +
        std::to_string(all.size()) +
        "\nproperty uint packed_position\nproperty uint packed_rotation\n"
        "property uint packed_scale\nproperty uint packed_color\nend_header\n";
    for (const float v : {0.F, 0.F, 0.F, 5.F, 5.F, 5.F, -6.F, -6.F, -6.F, 2.F, 2.F, 2.F})
        out += raw(v);
    const auto bits = [](double unit, int width) {
        return static_cast<std::uint32_t>(std::lround(unit * ((1 << width) - 1)));
    };
    const auto three = [&](Vec3d v) {
        return bits(v.x, 11) << 21 | bits(v.y, 10) << 11 | bits(v.z, 11);
    };
    for (const Splat& s : all) {
        out += raw(three(s.position / 5.0));
        std::size_t largest = 0;
        for (std::size_t k = 1; k < 4; ++k)
            if (s.rotation[k] > s.rotation[largest]) largest = k;
        auto rotation = static_cast<std::uint32_t>(largest);
        for (std::size_t k = 0; k < 4; ++k)
            if (k != largest)
                rotation = rotation << 10 | bits(s.rotation[k] / (2 * kHalf) + 0.5, 10);
        out += raw(rotation);
        const auto share = [](double sigma) { return (std::log(sigma) + 6) / 8; };
        out += raw(three({share(s.sigmas.x), share(s.sigmas.y), share(s.sigmas.z)}));
        out += raw(0x80808000U | bits(s.opacity, 8));
    }
    return out;
}

double angle_cos(Vec3f a, Vec3f b) {
    const Vec3d u = vec_cast<double>(a), v = vec_cast<double>(b);
    return std::abs(dot(u, v)) / std::sqrt(squared_length(u) * squared_length(v));
}

/// What splats() become, within the precision of the formats.
void expect_surfels(const LoadResult& result) {
    const PointCloud& cloud = result.cloud;
    EXPECT_EQ(result.report.num_rows, 8U);
    EXPECT_EQ(result.report.num_left_out, 3U);
    ASSERT_EQ(cloud.size(), 5U);
    EXPECT_TRUE(has_note(result, "1 splat dropped: opacity below 0.1"));
    EXPECT_TRUE(has_note(result, "1 splat dropped: needles, thinner than 1 : 20"));
    EXPECT_TRUE(has_note(result, "1 splat dropped: more than 5 times the median size"));
    for (const DroppedPoint& d : cloud.dropped) EXPECT_EQ(d.reason, DropReason::kNoSurfel);
    ASSERT_EQ(cloud.normals.size(), 5U);
    ASSERT_EQ(cloud.axes.size(), 5U);
    ASSERT_EQ(cloud.given_normals, std::vector<std::uint8_t>(5, 0));
    const std::size_t a = point_of_row(cloud, 0), b = point_of_row(cloud, 1),
                      c = point_of_row(cloud, 2), round = point_of_row(cloud, 7);
    EXPECT_GT(angle_cos(cloud.normals[a], {0, 0, 1}), 0.9999);
    EXPECT_GT(angle_cos(cloud.axes[a].u, {1, 0, 0}), 0.9999);
    EXPECT_GT(angle_cos(cloud.axes[a].v, {0, 1, 0}), 0.9999);
    EXPECT_NEAR(std::sqrt(squared_length(cloud.axes[a].u)), 0.2F, 0.008F);
    EXPECT_NEAR(std::sqrt(squared_length(cloud.axes[a].v)), 0.1F, 0.004F);
    EXPECT_GT(angle_cos(cloud.normals[b], {1, 0, 0}), 0.999);
    EXPECT_GT(angle_cos(cloud.axes[b].u, {0, 0, 1}), 0.999);
    EXPECT_GT(angle_cos(cloud.normals[c], {1, 0, 0}), 0.9999);
    EXPECT_EQ(cloud.normals[round], Vec3f{}) << "not flat";
    EXPECT_EQ(result.report.num_zero_normals, 1U);
    EXPECT_NEAR(cloud.weights[a], 0.9F, 0.003F);
    EXPECT_NEAR(cloud.areas[a], 2 * 3.14159265 * 0.2 * 0.1 * 0.9, 0.006);
    EXPECT_NEAR(cloud.positions[b].x, 1.0, 0.003);
    EXPECT_NEAR(cloud.colors[a].r, 0.5 * 65535, 300);
    EXPECT_TRUE(cloud.channels.empty());
}

TEST(Splats, EveryFormatGivesTheSameSurfels) {
    const std::vector<std::pair<std::string, std::string>> files{
        {"a.ply", splat_ply(splats())},   {"a.splat", splat_file(splats())},
        {"a.spz", spz_file(splats(), 1)}, {"a.spz", spz_file(splats(), 2)},
        {"a.spz", spz_file(splats(), 3)}, {"a.spz", spz_file(splats(), 4)},
        {"a.ply", packed_ply(splats())},
    };
    for (const auto& [name, bytes] : files) {
        SCOPED_TRACE(name + ", " + std::to_string(bytes.size()) + " bytes");
        expect_surfels(load_as(name, bytes));
        EXPECT_EQ(load_as(name, bytes).cloud.frame.up,
                  name == "a.spz" ? UpAxis::kY : UpAxis::kMinusY);
        const LoadResult one = load_as(name, bytes, {}, {.threads = 1});
        const LoadResult four = load_as(name, bytes, {}, {.threads = 4});
        EXPECT_EQ(one.cloud.normals, four.cloud.normals);
        EXPECT_EQ(one.cloud.areas, four.cloud.areas);
    }
}

TEST(Splats, FlatOnesHaveTheThirdAxisForANormal) {
    const PointCloud cloud = load_as("a.ply", splat_ply(splats(), true)).cloud;
    EXPECT_GT(angle_cos(cloud.normals[point_of_row(cloud, 0)], {0, 0, 1}), 0.9999);
    EXPECT_GT(angle_cos(cloud.normals[point_of_row(cloud, 7)], {0, 0, 1}), 0.9999);
}

TEST(Splats, ColorsWithoutShapesArePoints) {
    const LoadResult result = load_bytes(make_ply(
        "ascii",
        {three_points({column("float", "f_dc_0", {0, 0, 0}), column("float", "f_dc_1", {0, 0, 0}),
                       column("float", "f_dc_2", {0, 0, 0})})}));
    EXPECT_EQ(result.cloud.size(), 3U);
    EXPECT_TRUE(result.cloud.axes.empty());
    EXPECT_EQ(result.cloud.frame.up, UpAxis::kAuto);
}

TEST(Splats, BrokenOnesAreDropped) {
    std::vector<Splat> all = splats();
    all[0].rotation = {0, 0, 0, 0};
    all[1].position.x = std::nan("");
    const LoadResult result = load_as("a.ply", splat_ply(all));
    EXPECT_TRUE(has_note(result, "1 splat dropped: size, rotation or opacity is no number"));
    EXPECT_EQ(result.report.num_non_finite, 1U);
    EXPECT_EQ(result.report.num_kept, 3U);
    for (Splat& s : all) s.opacity = 0.01;
    expect_load_error("a.ply", splat_ply(all), ErrorCode::kEmpty, "7 splats dropped: opacity");
}

TEST(Splats, SizesWhoseSquareOverflowsAreDropped) {
    std::vector<Splat> all = splats();
    const std::uint64_t num_kept = load_as("a.splat", splat_file(all)).report.num_kept;
    all[0].sigmas = {1e20, 1e20, 1};
    const LoadResult result = load_as("a.splat", splat_file(all));
    EXPECT_TRUE(has_note(result, "1 splat dropped: size, rotation or opacity is no number"));
    EXPECT_EQ(result.report.num_kept, num_kept - 1);
    // All of them, so that none is more than 5 times the median
    for (Splat& s : all) s.sigmas = {1e20, 1e20, 1};
    expect_load_error("a.splat", splat_file(all), ErrorCode::kEmpty, "out of range");
}

TEST(Splats, FilesThatLieAreErrors) {
    const ErrorCode code = ErrorCode::kInvalidInput;
    expect_load_error("a.splat", splat_file(splats()) + "x", code,
                      "257 bytes are not a whole number of splats of 32 bytes");
    std::string huge = spz_file(splats(), 2);
    huge.replace(8, 4, "\xfe\xff\xff\xff");
    expect_load_error("a.spz", huge, code, "promises 4294967294 splats, but their data end at");
    huge = spz_file(splats(), 4);
    huge.replace(8, 4, "\xfe\xff\xff\xff");
    expect_load_error("a.spz", huge, code, "4294967294 splats need");
    std::string newer = spz_file(splats(), 3);
    newer[4] = 9;
    expect_load_error("a.spz", newer, ErrorCode::kUnsupported, "SPZ of version 9; 1 to 4");
    std::string few = packed_ply(splats());
    few.replace(few.find("chunk 1"), 7, "chunk 0");
    expect_load_error("a.ply", few, code, "need 1 rows of 'chunk'");
}

TEST(Splats, EveryCutAndFlipIsAnErrorOrACloud) {
    const TempFolder folder;
    for (const auto& [name, whole] :
         {std::pair{"a.splat", splat_file(splats())}, std::pair{"a.spz", spz_file(splats(), 1)},
          std::pair{"a.spz", spz_file(splats(), 3)}, std::pair{"a.spz", spz_file(splats(), 4)},
          std::pair{"a.ply", packed_ply(splats())}})
        for (std::size_t i = 0; i < whole.size(); ++i)
            for (int flip : {0, 0xff}) {
                std::string bytes = flip == 0 ? whole.substr(0, i) : whole;
                if (flip != 0) bytes[i] = static_cast<char>(bytes[i] ^ flip);
                try {
                    EXPECT_LE(load_cloud(folder.write(name, bytes)).report.num_rows, 300U);
                } catch (const Error& error) {
                    EXPECT_FALSE(std::string(error.what()).empty());
                }
            }
}

TEST(Splats, TheExponentialIsExact) {
    for (double x = -690.0; x < 690.0; x += 0.37)
        EXPECT_NEAR(portable_exp(x) / std::exp(x), 1.0, 1e-14) << x;
    EXPECT_EQ(portable_exp(0.0), 1.0);
    EXPECT_TRUE(std::isnan(portable_exp(std::nan(""))));
    EXPECT_TRUE(std::isfinite(portable_exp(1e300)));
}

}  // namespace
}  // namespace pointbake::test
