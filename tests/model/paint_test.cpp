#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "core/color.h"
#include "model/lettering.h"
#include "model/stroke_font.h"
#include "pointbake/model.h"

namespace pointbake {
namespace {

constexpr Vec3d kFront{0.0, 0.0, 1.0};

Rgb16 front(double x, double y) { return paint_at({x, y, 0.675}, kFront); }
bool is_ink(Rgb16 c) { return to_8bit(c.r) < 100 && to_8bit(c.b) < 120; }

// Share of ink in a box on the front face.
double ink_share(double left, double right, double low, double high) {
    constexpr int kSteps = 200;
    int ink = 0;
    for (int j = 0; j < kSteps; ++j)
        for (int i = 0; i < kSteps; ++i)
            ink += is_ink(front(left + (right - left) * (i + 0.5) / kSteps,
                                low + (high - low) * (j + 0.5) / kSteps));
    return static_cast<double>(ink) / (kSteps * kSteps);
}

TEST(StrokeFont, HoldsLettersDigitsAndPunctuation) {
    const std::string letters =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789.,:;!?-+=/'\"()%&";
    for (const char c : letters) EXPECT_FALSE(text_strokes(std::string(1, c)).strokes.empty()) << c;
    EXPECT_TRUE(text_strokes(" ").strokes.empty());
}

TEST(StrokeFont, KeepsCapitalsBetweenTheLines) {
    for (const Stroke& s : text_strokes("ABCDEFGHIJKLMNOPRSTUVWXYZ0123456789").strokes)
        for (const Vec2d p : {s.a, s.b}) {
            EXPECT_GE(p.y, -1e-12);
            EXPECT_LE(p.y, 1.0 + 1e-12);
        }
}

TEST(StrokeFont, GlyphsDifferFromEachOther) {
    std::map<std::vector<double>, char> seen;
    for (char c = '!'; c < 127; ++c) {
        std::vector<double> key;
        for (const Stroke& s : text_strokes(std::string(1, c)).strokes)
            key.insert(key.end(), {s.a.x, s.a.y, s.b.x, s.b.y});
        if (key.empty()) continue;
        EXPECT_TRUE(seen.emplace(key, c).second) << c << " looks like " << seen[key];
    }
}

TEST(Lettering, IsNotMirroredOnAnyFace) {
    for (const Vec3d n : {Vec3d{1, 0, 0}, Vec3d{-1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, -1, 0},
                          Vec3d{0, 0, 1}, Vec3d{0, 0, -1}}) {
        const BoxFace face = box_face(n);
        Vec3d right, up;
        for (std::size_t k = 0; k < 3; ++k) {
            Vec3d step;
            step[k] = 1.0;
            const Vec2d d = face_place(face, step) - face_place(face, {});
            right[k] = d.x;
            up[k] = d.y;
        }
        EXPECT_EQ(cross(right, up), n);
    }
}

TEST(Paint, ReadsFromLeftToRight) {
    // POINTBAKE: the first letter's stem is inked over its whole height, the arms of the last one
    // only in three places.
    const auto column = [](double x) {
        int ink = 0;
        for (int k = 0; k < 100; ++k) ink += is_ink(front(x, 0.163 + 0.078 * k / 100.0));
        return ink;
    };
    double left = 0.0, right = 1.0;
    while (left < 1.0 && column(left) < 5) left += 0.001;
    while (right > 0.0 && column(right) < 5) right -= 0.001;
    EXPECT_GT(left, 0.1);
    EXPECT_LT(left, 0.4);
    EXPECT_NEAR(left + right, 1.0, 0.02);
    EXPECT_GT(column(left + 0.008), 95);
    EXPECT_LT(column(right - 0.008), 75);
}

TEST(Paint, HasLetteringInSeveralSizes) {
    EXPECT_GT(ink_share(0.2, 0.8, 0.162, 0.242), 0.15);
    EXPECT_LT(ink_share(0.2, 0.8, 0.162, 0.242), 0.60);
    EXPECT_GT(ink_share(0.25, 0.75, 0.0790, 0.0975), 0.15);
    EXPECT_GT(ink_share(0.25, 0.75, 0.0580, 0.0690), 0.12);
    EXPECT_EQ(ink_share(0.03, 0.15, 0.06, 0.24), 0.0);
}

TEST(Paint, HasLargeConstantAreas) {
    const Rgb16 paper = front(0.05, 0.15);
    int same = 0, all = 0;
    for (double y = 0.06; y < 0.25; y += 0.002)
        for (double x = 0.03; x < 0.97; x += 0.005, ++all) same += front(x, y) == paper;
    EXPECT_GT(same, all / 2);
}

TEST(Paint, HasSoftEdgesOnAFlatFace) {
    // A step of 1e-4 is a fifteenth of an edge's ramp; two edges may fall together.
    constexpr double kStep = 1e-4;
    constexpr int kMaxChange = 2 * 16 + 2;
    for (const double y : {0.02, 0.047, 0.066, 0.085, 0.12, 0.2})
        for (double x = 0.03; x < 0.97; x += kStep) {
            const Rgb16 a = front(x, y), b = front(x + kStep, y);
            ASSERT_LE(std::abs(to_8bit(a.r) - to_8bit(b.r)), kMaxChange) << x << ' ' << y;
        }
}

TEST(Paint, CoversAllOfSpaceAndAnyNormal) {
    // Outside the box and for a zero normal too: a colour, and always the same.
    for (const Vec3d p : {Vec3d{-3, 0.1, 7}, Vec3d{0.5, 4, 0.5}, Vec3d{0.5, -1, 0.5}})
        for (const Vec3d n : {Vec3d{}, Vec3d{0.6, 0.8, 0}, Vec3d{0, -1, 0}})
            EXPECT_EQ(paint_at(p, n), paint_at(p, n));
}

TEST(Paint, ShowsABeeOnThePot) {
    int yellow = 0, dark = 0;
    for (double y = 0.40; y < 0.56; y += 0.002)
        for (double x = 0.34; x < 0.54; x += 0.002) {
            const Rgb16 c = paint_at({x, y, 0.5}, kFront);
            yellow += to_8bit(c.r) > 240 && to_8bit(c.b) < 60;
            dark += is_ink(c);
        }
    EXPECT_GT(yellow, 200);
    EXPECT_GT(dark, 200);
}

}  // namespace
}  // namespace pointbake
