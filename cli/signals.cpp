#include "signals.h"

#include <signal.h>

#include <array>
#include <chrono>

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

}  // namespace

StopOnSignal::StopOnSignal() {
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
