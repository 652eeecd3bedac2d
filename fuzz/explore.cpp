// One target, driven by libFuzzer: POINTBAKE_FUZZ_TARGET is its name.
#include <cstdint>

#include "pointbake/error.h"
#include "targets.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    for (const pointbake::fuzz::Target& target : pointbake::fuzz::targets()) {
        if (target.name != POINTBAKE_FUZZ_TARGET) continue;
        try {
            target.run(std::as_bytes(std::span(data, size)));
        } catch (const pointbake::Error&) {
        }
    }
    return 0;
}
