#include "console.h"

#include <gtest/gtest.h>

namespace pointbake::cli {
namespace {

TEST(Text, GroupsThousands) {
    EXPECT_EQ(grouped(0), "0");
    EXPECT_EQ(grouped(999), "999");
    EXPECT_EQ(grouped(1000), "1,000");
    EXPECT_EQ(grouped(12345678), "12,345,678");
    EXPECT_EQ(counted(1, "page"), "1 page");
    EXPECT_EQ(counted(2000, "page"), "2,000 pages");
}

TEST(Text, WritesBytesInTheUnitThatSuits) {
    EXPECT_EQ(bytes_text(1200), "1.2 kB");
    EXPECT_EQ(bytes_text(345'600'000), "346 MB");
    EXPECT_EQ(bytes_text(12'000'000'000), "12 GB");
}

TEST(ProgressEstimate, GrowsFromNothingToAllOverTheStages) {
    ProgressEstimate estimate;
    double last = 0.0;
    for (const char* stage :
         {"load", "attributes", "reconstruct", "simplify", "texture", "write"}) {
        for (const double fraction : {0.0, 0.5, 1.0}) {
            estimate.report(stage, fraction);
            EXPECT_GE(estimate.total(), last) << stage;
            last = estimate.total();
        }
    }
    EXPECT_DOUBLE_EQ(last, 1.0);
}

TEST(ProgressEstimate, NeverGoesBackAndIgnoresStrangers) {
    ProgressEstimate estimate;
    estimate.report("simplify", 0.5);
    const double before = estimate.total();
    estimate.report("load", 0.1);
    estimate.report("somewhere else", 1.0);
    estimate.report("simplify", 7.0);
    EXPECT_GT(estimate.total(), before);
    EXPECT_LT(estimate.total(), 1.0);
}

TEST(ProgressEstimate, TellsTheRemainingTimeOnceItCan) {
    ProgressEstimate estimate;
    EXPECT_LT(estimate.seconds_left(1.0), 0.0);
    estimate.report("write", 1.0);
    EXPECT_DOUBLE_EQ(estimate.seconds_left(5.0), 0.0);
}

}  // namespace
}  // namespace pointbake::cli
