#pragma once

#include <string>

namespace tactile {

/// Lets the calling thread go ahead of all usual ones (SCHED_FIFO), and be woken to the microsecond.
/// @param priority  1 to 99
/// @return  why it may not; empty if it may
std::string go_ahead_of_others(int priority);

/// Keeps the process's memory, present and to come, from being paged out. @return  why it may not; empty if it may
std::string lock_memory();

}  // namespace tactile
