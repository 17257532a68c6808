#pragma once

#include <mutex>
#include <string>
#include <vector>

#include "tactile/events/file_descriptor.hpp"

namespace tactile::detect {

/// Gives the calling thread real-time priority (SCHED_FIFO) and timers that are accurate to the microsecond.
/// @param priority  1 to 99
/// @return  why the system refuses; empty if it permits
std::string use_real_time_priority(int priority);

/// Prevents that the process's present and future memory is paged out. @return  why the system refuses; empty if it permits
std::string lock_memory();

/// What the system refused of real-time priority and locked memory, each reason once. Any thread may use it.
class RealTimeRefusals {
 public:
  void add(const std::string& why);  ///< nothing if empty
  std::vector<std::string> all() const;

 private:
  mutable std::mutex guard_;
  std::vector<std::string> reasons_;
};

/// Keeps all processor cores awake during its lifetime. To wake a core takes tens of microseconds, and the core is slower at
/// first. Awake cores use more power.
///
/// Source: Linux, Documentation/power/pm_qos_interface.rst: a latency of 0 us held in /dev/cpu_dma_latency.
class AwakeProcessors {
 public:
  AwakeProcessors();
  const std::string& refused() const { return refused_; }  ///< why the cores may sleep; empty if they stay awake

 private:
  events::FileDescriptor latency_;
  std::string refused_;
};

}  // namespace tactile::detect
