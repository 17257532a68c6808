#pragma once

#include <functional>
#include <future>

namespace tactile {

/// Starts `work` beside the caller, if there may be more than one thread (0: one per core). Otherwise, or if no thread can be
/// made, `work` is done here, and what it throws is thrown here.
/// What `work` calls has threads of its own, besides those of the caller.
/// @return  waits for `work` and throws what it throws; not valid if it is done
std::future<void> start_beside(unsigned threads, std::function<void()> work);

}  // namespace tactile
