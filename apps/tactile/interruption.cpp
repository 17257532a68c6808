#include "interruption.hpp"

#include <csignal>
#include <ctime>
#include <initializer_list>

namespace tactile::cli {
namespace {

volatile std::sig_atomic_t raised = 0;        ///< the last signal
volatile std::sig_atomic_t raised_at_ms = 0;  ///< when it first came, on the steady clock; the lower digits suffice

std::sig_atomic_t now_ms() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<std::sig_atomic_t>((now.tv_sec % 1'000'000) * 1000 + now.tv_nsec / 1'000'000);
}

/// A signal raises the flag. The same signal again ends the process, but not within half a second: `timeout` sends it twice, to
/// the process and to its group.
void on_signal(int number) {
  if (raised != number) {
    raised_at_ms = now_ms();
    raised = number;
  } else if (now_ms() - raised_at_ms > 500 || now_ms() < raised_at_ms) {
    std::signal(number, SIG_DFL);
    std::raise(number);
  }
}

void catch_signal(int number) {
  struct sigaction action {};
  action.sa_handler = on_signal;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  sigaction(number, &action, nullptr);
}

sigset_t held_signals() {
  sigset_t held;
  sigemptyset(&held);
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&held, number);
  return held;
}

}  // namespace

void hold_signals() {
  const sigset_t held = held_signals();
  pthread_sigmask(SIG_BLOCK, &held, nullptr);
}

void release_signals() {
  const sigset_t held = held_signals();
  pthread_sigmask(SIG_UNBLOCK, &held, nullptr);
}

void catch_signals() {
  static const bool caught = [] {
    catch_signal(SIGINT);
    catch_signal(SIGTERM);
    struct sigaction present {};
    const bool is_ignored = sigaction(SIGHUP, nullptr, &present) == 0 && present.sa_handler == SIG_IGN;
    if (!is_ignored) catch_signal(SIGHUP);  // under nohup the command continues without the terminal
    return true;
  }();
  static_cast<void>(caught);
}

void fail_at_broken_pipes() { std::signal(SIGPIPE, SIG_IGN); }
void fail_at_file_size_limit() { std::signal(SIGXFSZ, SIG_IGN); }

bool interrupted() { return raised != 0; }
int exit_code_of_interruption() { return 128 + raised; }

}  // namespace tactile::cli
