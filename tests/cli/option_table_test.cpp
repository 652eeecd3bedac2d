#include "option_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "pointbake/convert.h"
#include "pointbake/write.h"
#include "run_options.h"

namespace pointbake::cli {
namespace {

struct Fixture {
    SimplifyOptions simplify;
    ReconstructOptions reconstruct;
    TextureOptions texture;
    WriteOptions write;
    LimitOptions limits;
    RunOptions run;
    OptionTable table;

    Fixture() {
        table.add(OptionGroup::kGeometry, true, simplify);
        table.add(OptionGroup::kGeometry, true, reconstruct);
        table.add(OptionGroup::kTexture, true, texture);
        table.add(OptionGroup::kOutput, true, write);
        table.add(OptionGroup::kRunning, false, limits);
        table.add(OptionGroup::kRunning, false, run);
    }
};

ErrorCode code_of(const std::function<void()>& body) {
    try {
        body();
    } catch (const Error& error) {
        return error.code();
    }
    ADD_FAILURE() << "nothing was thrown";
    return ErrorCode::kCancelled;
}

std::string message_of(const std::function<void()>& body) {
    try {
        body();
    } catch (const Error& error) {
        return error.what();
    }
    return "nothing was thrown";
}

TEST(OptionTable, SetsEveryKindOfValue) {
    Fixture f;
    f.table.set("triangles", "5000");
    f.table.set("keep-mesh", "true");
    f.table.set("geometry-error", "0.1%");
    f.table.set("texture-error", "2.5");
    f.table.set("texels", "5000000000");
    f.table.set("surface", "watertight");
    f.table.set("max-memory", "12G");
    f.table.set("progress", "json");
    EXPECT_EQ(f.simplify.triangles, 5000U);
    EXPECT_TRUE(f.simplify.keep_mesh);
    EXPECT_EQ(f.simplify.geometry_error, fraction(0.001));
    EXPECT_EQ(f.texture.texture_error, 2.5);
    EXPECT_EQ(f.texture.texels, 5'000'000'000U);
    EXPECT_EQ(f.reconstruct.surface, Surface::kWatertight);
    EXPECT_EQ(f.limits.max_memory->bytes, 12ULL << 30);
    EXPECT_EQ(f.run.progress, ProgressMode::kJson);
}

TEST(OptionTable, ReadsThousandsAndMillions) {
    Fixture f;
    for (const auto& [text, count] :
         std::vector<std::pair<const char*, std::uint32_t>>{{"250k", 250'000},
                                                            {"10K", 10'000},
                                                            {"1.5M", 1'500'000},
                                                            {"0.001k", 1},
                                                            {"4294967295", 4'294'967'295}}) {
        f.table.set("triangles", text);
        EXPECT_EQ(f.simplify.triangles, count) << text;
    }
}

TEST(OptionTable, RefusesWhatIsNoValueAndNamesTheOption) {
    Fixture f;
    for (const auto& [name, text] :
         std::vector<std::pair<const char*, const char*>>{{"triangles", "-1"},
                                                          {"triangles", "5 k"},
                                                          {"triangles", "0.0001k"},
                                                          {"triangles", "infM"},
                                                          {"triangles", "k"},
                                                          {"triangles", "-5k"},
                                                          {"triangles", "5000M"},
                                                          {"triangles", "4294967296"},
                                                          {"triangles", ""},
                                                          {"texture-error", "nan"},
                                                          {"texture-error", "four"},
                                                          {"geometry-error", "3 parsecs"},
                                                          {"surface", "closed"},
                                                          {"max-memory", "-1G"},
                                                          {"max-memory", "lots"},
                                                          {"keep-mesh", "maybe"}}) {
        const auto set = [&] { f.table.set(name, text); };
        EXPECT_EQ(code_of(set), ErrorCode::kInvalidOption) << name << " " << text;
        EXPECT_THAT(message_of(set), testing::HasSubstr(std::string("--") + name));
    }
    EXPECT_THAT(message_of([&] { f.table.set("surface", "closed"); }),
                testing::HasSubstr("auto, open, watertight, given"));
}

TEST(OptionTable, DumpReadsBackToTheSameDump) {
    Fixture a, b;
    a.table.set("geometry-error", "2mm");
    a.table.set("texels", "1000000");
    a.table.set("keep-mesh", "true");
    a.table.set("scale", "0.001");
    b.table.set_from_json(a.table.dump(false), "a.json");
    EXPECT_EQ(a.table.dump(false), b.table.dump(false));
    EXPECT_NE(a.table.dump(false), Fixture().table.dump(false));
}

TEST(OptionTable, DumpForTheReportLeavesOutHowItRan) {
    Fixture f;
    f.table.set("threads", "7");
    const auto json = nlohmann::json::parse(f.table.dump(true));
    EXPECT_TRUE(json.contains("triangles"));
    EXPECT_FALSE(json.contains("threads"));
    EXPECT_EQ(nlohmann::json::parse(f.table.dump(false))["threads"], 7);
}

TEST(OptionTable, FlagsWinOverJson) {
    Fixture f;
    f.table.set("triangles", "100");
    f.table.set_from_json(R"({"triangles": 200, "texels": 300, "texture-error": null})", "c.json");
    EXPECT_EQ(f.simplify.triangles, 100U);
    EXPECT_EQ(f.texture.texels, 300U);
    EXPECT_FALSE(f.texture.texture_error.has_value());
}

TEST(OptionTable, RefusesJsonThatHoldsNoOptions) {
    Fixture f;
    for (const char* text : {"", "[]", "{", "3", R"({"triangles": [1]})", R"({"triangles": -3})",
                             R"({"triangles": 2.5})", R"({"triangels": 3})"})
        EXPECT_EQ(code_of([&] { f.table.set_from_json(text, "c.json"); }),
                  ErrorCode::kInvalidOption)
            << text;
    EXPECT_THAT(message_of([&] { f.table.set_from_json(R"({"triangels": 3})", "c.json"); }),
                testing::AllOf(testing::HasSubstr("c.json"), testing::HasSubstr("'triangles'")));
}

TEST(OptionTable, ScaleTurnsMetresAloneIntoUnits) {
    ConvertOptions options;
    const auto in_millimetres = [&](std::string_view text) {
        OptionTable table;
        table.add(OptionGroup::kGeometry, true, options.simplify);
        table.set("geometry-error", text);
        const ConvertOptions settled = in_cloud_units(options, {.metres_per_unit = 0.001});
        return settled.simplify.geometry_error->in_units(10.0);
    };
    EXPECT_DOUBLE_EQ(in_millimetres("2mm"), 2.0);
    EXPECT_DOUBLE_EQ(in_millimetres("2"), 2.0);
    EXPECT_DOUBLE_EQ(in_millimetres("0.2%"), 0.02);
    options.clean.subsample = metres(0.5);
    options.reconstruct.fill_holes = metres(0.25);
    const ConvertOptions settled = in_cloud_units(options, {.metres_per_unit = 0.3048});
    EXPECT_DOUBLE_EQ(settled.clean.subsample->in_units(1.0), 0.5 / 0.3048);
    EXPECT_DOUBLE_EQ(settled.reconstruct.fill_holes->in_units(1.0), 0.25 / 0.3048);
}

TEST(NearestName, FindsTypingSlipsAndParts) {
    const std::vector<std::string_view> known = {"triangles", "texels", "texture-error", "threads"};
    EXPECT_EQ(nearest_name(known, "trangles"), "triangles");
    EXPECT_EQ(nearest_name(known, "txeels"), "texels");
    EXPECT_EQ(nearest_name(known, "error"), "texture-error");
    EXPECT_EQ(nearest_name(known, "thread"), "threads");
    EXPECT_EQ(nearest_name({}, "x"), "");
}

}  // namespace
}  // namespace pointbake::cli
