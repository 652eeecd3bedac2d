// Log lines, progress and asserts, in one line each at the place where they are needed.
#pragma once

#include <fmt/format.h>

#include <string_view>

#include "pointbake/context.h"
#include "pointbake/error.h"

namespace pointbake {

template <class... Args>
void log(const Context& context, LogLevel level, fmt::format_string<Args...> format,
         Args&&... args) {
    if (context.log) context.log(level, fmt::format(format, std::forward<Args>(args)...));
}

inline void report_progress(const Context& context, std::string_view stage, double fraction) {
    if (context.progress) context.progress(stage, fraction);
}

template <class... Args>
[[noreturn]] void fail(ErrorCode code, fmt::format_string<Args...> format, Args&&... args) {
    throw Error(code, fmt::format(format, std::forward<Args>(args)...));
}

/// For bugs of ours, never for bad input. On in dev and sanitizer builds.
#ifdef POINTBAKE_ASSERTS
#define POINTBAKE_ASSERT(condition, ...)                                                          \
    do {                                                                                          \
        static_assert(std::is_same_v<decltype(condition), bool>, "the condition must be a bool"); \
        if (!(condition))                                                                         \
            ::pointbake::assertion_failed(__FILE__, __LINE__, #condition,                         \
                                          fmt::format(__VA_ARGS__));                              \
    } while (false)
#else
#define POINTBAKE_ASSERT(condition, ...) static_cast<void>(0)
#endif
[[noreturn]] void assertion_failed(const char* file, int line, const char* condition,
                                   const std::string& message);

}  // namespace pointbake
