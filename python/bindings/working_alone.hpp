#pragma once

#include <mutex>

#include "other_threads_run.hpp"

namespace tactile::python {

/// While it exists, Python's other threads run, and those that want the same mutex wait. The mutex is given back before the GIL
/// is taken again, so that neither waits for the other.
struct WorkingAlone {
  explicit WorkingAlone(std::mutex& mutex) : lock(mutex) {}

  OtherThreadsRun other_threads_run;
  std::scoped_lock<std::mutex> lock;
};

}  // namespace tactile::python
