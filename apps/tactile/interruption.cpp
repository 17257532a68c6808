#include "interruption.hpp"

#include <csignal>

namespace tactile {
namespace {

volatile std::sig_atomic_t raised = 0;

void catch_signal(int number) {
  struct sigaction action {};
  action.sa_handler = [](int) { raised = 1; };
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);  // once: a second signal finds the default action
  sigemptyset(&action.sa_mask);
  sigaction(number, &action, nullptr);
}

}  // namespace

void catch_ctrl_c() {
  static const bool caught = (catch_signal(SIGINT), true);
  static_cast<void>(caught);
}

void catch_termination() {
  static const bool caught = (catch_signal(SIGTERM), true);
  static_cast<void>(caught);
}

bool interrupted() { return raised != 0; }

}  // namespace tactile
