#include "tactile/core/start_beside.hpp"

#include <system_error>

#include "tactile/core/parallel.hpp"

namespace tactile {

std::future<void> start_beside(unsigned threads, std::function<void()> work) {
  if (threads_or_all(threads) > 1) {
    try {
      return std::async(std::launch::async, work);
    } catch (const std::system_error&) {
      // No thread can be made.
    }
  }
  work();
  return {};
}

}  // namespace tactile
