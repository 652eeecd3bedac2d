#include "signals.h"

#include <signal.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstring>

#include "core/mapped_file.h"

namespace pointbake::cli {
namespace {

// How long the end of the program may wait for the watcher.
constexpr std::chrono::milliseconds kPoll{10};

sigset_t stop_signals() {
    sigset_t set;
    sigemptyset(&set);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&set, signal);
    return set;
}

void print(const char* text) {
    // Nothing can be done about a stderr that is closed.
    [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, text, std::strlen(text));
}

/// An input that became shorter, or whose disk fails, while it is read. No file is being written
/// then, so that the end may be at once.
void end_for_lost_input(int signal_number, siginfo_t* info, void*) {
    constexpr int kInputUnreadable = 3;
    const char* const name = MappedFile::name_at(info->si_addr);
    if (name == nullptr) {
        signal(signal_number, SIG_DFL);
        return;
    }
    print("pointbake: error: ");
    print(name);
    print(": cannot be read to its end: it became shorter meanwhile, or its disk fails\n");
    ::_exit(kInputUnreadable);
}

}  // namespace

StopOnSignal::StopOnSignal() {
    struct sigaction lost_input{};
    lost_input.sa_sigaction = end_for_lost_input;
    lost_input.sa_flags = SA_SIGINFO;
    sigaction(SIGBUS, &lost_input, nullptr);
    // A closed pipe and a full quota are errors of a write, not reasons to die and leave a
    // temporary file behind.
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN);
    const sigset_t set = stop_signals();
    pthread_sigmask(SIG_BLOCK, &set, nullptr);
    watcher_ = std::jthread([this](const std::stop_token& ending) { watch(ending); });
}

void StopOnSignal::watch(const std::stop_token& ending) {
    const sigset_t set = stop_signals();
    const timespec poll{.tv_sec = 0, .tv_nsec = std::chrono::nanoseconds(kPoll).count()};
    while (!ending.stop_requested()) {
        if (sigtimedwait(&set, nullptr, &poll) < 0) continue;
        source_.request_stop();
        // From now on this thread lets signals through, and their default action ends the process.
        pthread_sigmask(SIG_UNBLOCK, &set, nullptr);
        while (!ending.stop_requested()) std::this_thread::sleep_for(kPoll);
    }
}

}  // namespace pointbake::cli
