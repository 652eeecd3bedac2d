// Small fixed-size vectors. Plain aggregates: no hidden state, no alignment surprises.
#pragma once

#include <cmath>
#include <cstddef>

namespace pointbake {

template <class T>
struct Vec2 {
    T x{}, y{};

    constexpr T& operator[](std::size_t i) { return i == 0 ? x : y; }
    constexpr const T& operator[](std::size_t i) const { return i == 0 ? x : y; }
    friend constexpr bool operator==(const Vec2&, const Vec2&) = default;
};

template <class T>
struct Vec3 {
    T x{}, y{}, z{};

    constexpr T& operator[](std::size_t i) { return i == 0 ? x : (i == 1 ? y : z); }
    constexpr const T& operator[](std::size_t i) const { return i == 0 ? x : (i == 1 ? y : z); }
    friend constexpr bool operator==(const Vec3&, const Vec3&) = default;
};

using Vec2f = Vec2<float>;
using Vec2d = Vec2<double>;
using Vec3f = Vec3<float>;
using Vec3d = Vec3<double>;

template <class T>
constexpr Vec2<T> operator+(Vec2<T> a, Vec2<T> b) {
    return {a.x + b.x, a.y + b.y};
}
template <class T>
constexpr Vec2<T> operator-(Vec2<T> a, Vec2<T> b) {
    return {a.x - b.x, a.y - b.y};
}
template <class T>
constexpr Vec2<T> operator*(Vec2<T> a, T s) {
    return {a.x * s, a.y * s};
}
template <class T>
constexpr Vec2<T> operator*(T s, Vec2<T> a) {
    return a * s;
}
template <class T>
constexpr Vec2<T> operator/(Vec2<T> a, T s) {
    return {a.x / s, a.y / s};
}
template <class T>
constexpr T dot(Vec2<T> a, Vec2<T> b) {
    return a.x * b.x + a.y * b.y;
}
/// Twice the signed area of the triangle (0, a, b).
template <class T>
constexpr T cross(Vec2<T> a, Vec2<T> b) {
    return a.x * b.y - a.y * b.x;
}
template <class T>
T length(Vec2<T> a) {
    return std::sqrt(dot(a, a));
}

template <class T>
constexpr Vec3<T> operator+(Vec3<T> a, Vec3<T> b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class T>
constexpr Vec3<T> operator-(Vec3<T> a, Vec3<T> b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class T>
constexpr Vec3<T> operator-(Vec3<T> a) {
    return {-a.x, -a.y, -a.z};
}
template <class T>
constexpr Vec3<T> operator*(Vec3<T> a, T s) {
    return {a.x * s, a.y * s, a.z * s};
}
template <class T>
constexpr Vec3<T> operator*(T s, Vec3<T> a) {
    return a * s;
}
template <class T>
constexpr Vec3<T> operator/(Vec3<T> a, T s) {
    return {a.x / s, a.y / s, a.z / s};
}
template <class T>
constexpr Vec3<T>& operator+=(Vec3<T>& a, Vec3<T> b) {
    return a = a + b;
}
template <class T>
constexpr Vec3<T>& operator-=(Vec3<T>& a, Vec3<T> b) {
    return a = a - b;
}
template <class T>
constexpr T dot(Vec3<T> a, Vec3<T> b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
constexpr Vec3<T> cross(Vec3<T> a, Vec3<T> b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class T>
constexpr T squared_length(Vec3<T> a) {
    return dot(a, a);
}
template <class T>
T length(Vec3<T> a) {
    return std::sqrt(dot(a, a));
}
/// Unit vector along a; the zero vector stays zero.
template <class T>
Vec3<T> normalized(Vec3<T> a) {
    const T l = length(a);
    return l > T(0) ? a / l : Vec3<T>{};
}
template <class To, class T>
constexpr Vec2<To> vec_cast(Vec2<T> a) {
    return {static_cast<To>(a.x), static_cast<To>(a.y)};
}
template <class To, class T>
constexpr Vec3<To> vec_cast(Vec3<T> a) {
    return {static_cast<To>(a.x), static_cast<To>(a.y), static_cast<To>(a.z)};
}
template <class T>
bool is_finite(Vec3<T> a) {
    return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z);
}

/// Axis-aligned box; empty until the first extend().
struct Box {
    Vec3d low{HUGE_VAL, HUGE_VAL, HUGE_VAL};
    Vec3d high{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};

    void extend(Vec3d p) {
        for (std::size_t k = 0; k < 3; ++k) {
            if (p[k] < low[k]) low[k] = p[k];
            if (p[k] > high[k]) high[k] = p[k];
        }
    }
    bool is_empty() const { return !(low.x <= high.x); }
    Vec3d extent() const { return is_empty() ? Vec3d{} : high - low; }
    Vec3d center() const { return is_empty() ? Vec3d{} : (low + high) * 0.5; }
    double diagonal() const { return length(extent()); }
};

}  // namespace pointbake
