// pointbake: point clouds become textured meshes. This file finds the command and turns what goes
// wrong into a message and an exit code; the one catch of the program is here.
#include <array>
#include <new>
#include <vector>

#include "commands.h"
#include "console.h"
#include "signals.h"

namespace pointbake::cli {
namespace {

constexpr std::array<Command, 8> kCommands = {{{"convert", run_convert},
                                               {"info", run_info},
                                               {"reconstruct", run_reconstruct},
                                               {"simplify", run_simplify},
                                               {"texture", run_texture},
                                               {"render", run_render},
                                               {"sample", run_sample},
                                               {"demo", run_demo}}};

enum ExitCode : int {
    kOk = 0,
    kBug = 1,
    kUsage = 2,
    kInputUnreadable = 3,
    kOutputUnwritable = 4,
    kLimitExceeded = 5,
    kNothingLeft = 6,
    kCancelledBySignal = 130,
};

ExitCode exit_code(ErrorCode code) {
    switch (code) {
        case ErrorCode::kInvalidOption:
            return kUsage;
        case ErrorCode::kInvalidInput:
        case ErrorCode::kUnsupported:
        case ErrorCode::kIo:
        case ErrorCode::kDegenerate:
            return kInputUnreadable;
        case ErrorCode::kOutput:
            return kOutputUnwritable;
        case ErrorCode::kLimit:
            return kLimitExceeded;
        case ErrorCode::kEmpty:
            return kNothingLeft;
        case ErrorCode::kCancelled:
            return kCancelledBySignal;
    }
    return kBug;
}

/// The first word names the command; any other first word belongs to a conversion.
void dispatch(Words words, const std::stop_token& stop) {
    for (const Command& command : kCommands)
        if (!words.empty() && words[0] == command.name) return command.run(words.subspan(1), stop);
    run_convert(words, stop);
}

int run(Words words) {
    try {
        const StopOnSignal signals;
        dispatch(words, signals.token());
        return kOk;
    } catch (const Error& error) {
        print_error(error.what());
        return exit_code(error.code());
    } catch (const std::bad_alloc&) {
        print_error("out of memory; fewer points need less (see --dry-run, --max-memory)");
        return kLimitExceeded;
    } catch (const std::exception& error) {
        print_error(fmt::format("{} (a bug of pointbake)", error.what()));
        return kBug;
    }
}

}  // namespace

std::span<const Command> commands() { return kCommands; }

}  // namespace pointbake::cli

int main(int argc, char** argv) {
    const std::vector<std::string> words(argv + 1, argv + argc);
    return pointbake::cli::run(words);
}
