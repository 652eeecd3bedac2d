// How one option's value is read from text and printed, by its type. A type that options may have
// is listed here, once.
#pragma once

#include <charconv>
#include <concepts>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "core/message.h"
#include "pointbake/options.h"
#include "pointbake/vec.h"

namespace pointbake::cli {

/// An amount of memory: "500M", "12G", or bytes.
struct ByteSize {
    std::uint64_t bytes = 0;
};

template <class T>
concept Worded = requires { EnumWords<T>::words; };

/// The text as a JSON string, quotes included.
std::string json_string(std::string_view text);

/// A count: digits, or a number before k or M (thousands, millions) that makes a whole one.
/// std::nullopt beyond 64 bits.
std::optional<std::uint64_t> parse_count(std::string_view text);

/// parse(text): the value; throws Error{kInvalidOption} saying what would be accepted.
/// json(value): the value as JSON text. kPlaceholder: its place in the help; none for a flag.
template <class T>
struct OptionValue;

template <>
struct OptionValue<bool> {
    static std::string placeholder() { return {}; }
    static bool parse(std::string_view text);
    static std::string json(bool value) { return value ? "true" : "false"; }
};

template <std::integral T>
    requires(!std::same_as<T, bool>)
struct OptionValue<T> {
    static std::string placeholder() { return "N"; }
    static T parse(std::string_view text) {
        const std::optional<std::uint64_t> value = parse_count(text);
        if (!value || *value > std::uint64_t{std::numeric_limits<T>::max()})
            fail(ErrorCode::kInvalidOption, "{} is out of range: at most {}", text,
                 std::numeric_limits<T>::max());
        return static_cast<T>(*value);
    }
    static std::string json(T value) { return fmt::format("{}", value); }
};

template <>
struct OptionValue<double> {
    static std::string placeholder() { return "X"; }
    static double parse(std::string_view text);
    static std::string json(double value) { return fmt::format("{}", value); }
};

template <>
struct OptionValue<Length> {
    static std::string placeholder() { return "LENGTH"; }
    static Length parse(std::string_view text) { return parse_length(text); }
    static std::string json(const Length& value) { return json_string(to_string(value)); }
};

template <>
struct OptionValue<ByteSize> {
    static std::string placeholder() { return "SIZE"; }
    static ByteSize parse(std::string_view text);
    static std::string json(ByteSize value) { return fmt::format("{}", value.bytes); }
};

template <>
struct OptionValue<HexColor> {
    static std::string placeholder() { return "RRGGBB"; }
    static HexColor parse(std::string_view text) { return parse_hex_color(text); }
    static std::string json(HexColor value) { return json_string(to_string(value)); }
};

template <>
struct OptionValue<Box> {
    static std::string placeholder() { return "BOX"; }
    static Box parse(std::string_view text) { return parse_box(text); }
    static std::string json(const Box& value) { return json_string(to_string(value)); }
};

template <>
struct OptionValue<Vec3d> {
    static std::string placeholder() { return "X,Y,Z|x|y|z"; }
    static Vec3d parse(std::string_view text);
    static std::string json(const Vec3d& value) {
        return json_string(fmt::format("{},{},{}", value.x, value.y, value.z));
    }
};

template <>
struct OptionValue<std::string> {
    static std::string placeholder() { return "TEXT"; }
    static std::string parse(std::string_view text) { return std::string(text); }
    static std::string json(const std::string& value) { return json_string(value); }
};

template <>
struct OptionValue<std::filesystem::path> {
    static std::string placeholder() { return "PATH"; }
    static std::filesystem::path parse(std::string_view text) { return text; }
    static std::string json(const std::filesystem::path& value) {
        return value.empty() ? "null" : json_string(value.string());
    }
};

template <Worded T>
struct OptionValue<T> {
    static std::string placeholder() {
        return fmt::format("{}", fmt::join(EnumWords<T>::words, "|"));
    }
    static T parse(std::string_view text) {
        if (const std::optional<T> value = from_word<T>(text)) return *value;
        fail(ErrorCode::kInvalidOption, "'{}' is not known: expected {}", text,
             fmt::join(EnumWords<T>::words, ", "));
    }
    static std::string json(T value) { return json_string(to_word(value)); }
};

template <class T>
struct OptionValue<std::optional<T>> {
    static std::string placeholder() { return OptionValue<T>::placeholder(); }
    static std::optional<T> parse(std::string_view text) { return OptionValue<T>::parse(text); }
    static std::string json(const std::optional<T>& value) {
        return value ? OptionValue<T>::json(*value) : "null";
    }
};

}  // namespace pointbake::cli
