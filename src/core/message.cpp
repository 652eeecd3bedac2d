#include "core/message.h"

#include <cstdio>
#include <cstdlib>

namespace pointbake {

void assertion_failed(const char* file, int line, const char* condition,
                      const std::string& message) {
    std::fprintf(stderr, "%s:%d: assertion failed: %s (%s)\n", file, line, condition,
                 message.c_str());
    std::abort();
}

}  // namespace pointbake
