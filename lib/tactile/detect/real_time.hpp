#pragma once

#include <string>

#include "tactile/events/file_descriptor.hpp"

namespace tactile {

/// Lets the calling thread go ahead of all usual ones (SCHED_FIFO), and be woken to the microsecond.
/// @param priority  1 to 99
/// @return  why it may not; empty if it may
std::string go_ahead_of_others(int priority);

/// Keeps the process's memory, present and to come, from being paged out. @return  why it may not; empty if it may
std::string lock_memory();

/// Keeps all processors awake while there is nothing to do, as long as it lives: to wake one that sleeps takes tens of
/// microseconds, and what it then does is slower at first. They take more power by it.
///
/// Source: Linux, Documentation/power/pm_qos_interface.rst: a latency of 0 us held in /dev/cpu_dma_latency.
class AwakeProcessors {
 public:
  AwakeProcessors();
  const std::string& refused() const { return refused_; }  ///< why they may sleep; empty if they may not

 private:
  FileDescriptor latency_;
  std::string refused_;
};

}  // namespace tactile
