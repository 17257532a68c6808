#pragma once

#include <cstddef>
#include <functional>

namespace tactile {

/// Calls `work(i)` once for every i in [0, count), on up to `threads` threads (0: as many as the machine has cores). The first
/// exception ends the calls not yet begun and is thrown again here.
void parallel_for(std::size_t count, unsigned threads, const std::function<void(std::size_t)>& work);

}  // namespace tactile
