#pragma once

#include <nanobind/nanobind.h>

#include <condition_variable>
#include <mutex>

#include "tactile/core/error.hpp"

namespace tactile::python {

/// The loops of all threads that have given up the GIL. A thread that asks for the GIL after Python has ended is killed in the
/// middle of C++, which aborts the process. Therefore the end of Python waits for them.
class RunningLoops {
 public:
  static RunningLoops& all() {
    static RunningLoops* const loops = new RunningLoops;  // never destroyed: threads may outlive main
    return *loops;
  }

  /// With the GIL. @throws Error  if Python ends
  void begin() {
    const std::scoped_lock lock(guard_);
    if (ends_) throw Error("Python ends; expected no further call");
    ++running_;
  }
  void end() {  ///< with the GIL
    const std::scoped_lock lock(guard_);
    --running_;
    ended_.notify_all();
  }
  bool must_end() const {
    const std::scoped_lock lock(guard_);
    return ends_;
  }

  /// Lets every loop end, and waits for them. Called with the GIL, by `atexit`.
  void end_all() {
    const nanobind::gil_scoped_release others_need_it;
    std::unique_lock lock(guard_);
    ends_ = true;
    ended_.wait(lock, [this] { return running_ == 0; });
  }

 private:
  mutable std::mutex guard_;
  std::condition_variable ended_;
  int running_ = 0;
  bool ends_ = false;
};

/// While it exists, Python's other threads run.
class OtherThreadsRun {
 public:
  OtherThreadsRun() = default;
  OtherThreadsRun(const OtherThreadsRun&) = delete;
  OtherThreadsRun& operator=(const OtherThreadsRun&) = delete;

 private:
  struct Counted {
    Counted() { RunningLoops::all().begin(); }
    ~Counted() { RunningLoops::all().end(); }
    Counted(const Counted&) = delete;
    Counted& operator=(const Counted&) = delete;
  };
  Counted counted_;  // outlives the release: it ends with the GIL
  nanobind::gil_scoped_release released_;
};

}  // namespace tactile::python
