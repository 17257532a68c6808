#pragma once

#include <nanobind/nanobind.h>

#include <chrono>

#include "other_threads_run.hpp"

namespace tactile::python {

/// Lets Ctrl-C, "Interrupt" of a notebook, or the end of Python end a loop that has given up the GIL.
class Interruption {
 public:
  /// Call it in each turn: it asks Python 50 times a second.
  /// @throws python_error, with what a signal's handler raises; Error, if Python ends
  void check() {
    const auto now = Clock::now();
    if (now - last_ < std::chrono::milliseconds(20)) return;
    last_ = now;
    if (RunningLoops::all().must_end()) throw Error("Python ends: the call was interrupted; expected to wait for its thread");
    const nanobind::gil_scoped_acquire python;
    if (PyErr_CheckSignals() != 0) throw nanobind::python_error();
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point last_ = Clock::now();
};

}  // namespace tactile::python
