#pragma once

#include <atomic>
#include <cassert>
#include <cstddef>
#include <functional>
#include <span>

namespace tactile {

/// `threads`, or as many as there are cores that this process may use if it is 0; > 0.
unsigned threads_or_all(unsigned threads);

/// Calls `work(i)` once for every i in [0, count), on up to `threads` threads (0: one per core). The first exception ends the
/// calls not yet begun and is thrown again here. Where `work` calls parallel_for itself, the calls within share the threads of
/// the outermost one, which are never more than its `threads`. A thread that is started within a call is not one of them.
void parallel_for(std::size_t count, unsigned threads, const std::function<void(std::size_t)>& work);

/// Calls `work(i, memory)` once for every i in [0, count), on up to one thread for each of `memories`, of which there must be
/// one. No two calls use the same memory at the same time. Of exceptions, as `parallel_for`.
template <class Memory, class Work>
void parallel_for_with(std::span<Memory> memories, std::size_t count, const Work& work) {
  assert(!memories.empty());
  std::atomic<std::size_t> next{0};
  parallel_for(memories.size(), static_cast<unsigned>(memories.size()), [&](std::size_t memory) {
    try {
      for (std::size_t i = next++; i < count; i = next++) work(i, memories[memory]);
    } catch (...) {
      next = count;
      throw;
    }
  });
}

}  // namespace tactile
