#include "tactile/model/training/blas_threads.hpp"

#include <dlfcn.h>

#include <cstddef>
#include <mutex>
#include <string>

#include "tactile/core/error.hpp"
#include "tactile/core/machine.hpp"

namespace tactile::model {
namespace {

/// False with another BLAS library.
bool keep_blas_to_one_thread() {
  using SetThreads = void (*)(int);
  static const bool kept = [] {
    const auto set_blas_threads = reinterpret_cast<SetThreads>(dlsym(RTLD_DEFAULT, "openblas_set_num_threads"));
    if (set_blas_threads != nullptr) set_blas_threads(1);
    return set_blas_threads != nullptr;
  }();
  return kept;
}

/// OpenBLAS allocates 128 MB for each calling thread, and tries forever if that fails. Therefore this checks that twice this
/// memory is available. @throws Error  if it is not
void check_room_for_blas(unsigned threads) {
  static std::mutex guard;
  static unsigned checked = 0;
  const std::scoped_lock lock(guard);
  if (threads <= checked) return;
  const std::size_t bytes = (threads - checked) * (std::size_t{256} << 20);
  if (!has_room_for(bytes)) {
    throw Error("memory: there is no room for another " + std::to_string(bytes >> 20) + " MB, which the network takes on " +
                std::to_string(threads) + (threads == 1 ? " thread" : " threads") +
                "; expected a higher limit (ulimit -v), or fewer --threads");
  }
  checked = threads;
}

}  // namespace

void prepare_blas(unsigned threads) {
  if (keep_blas_to_one_thread()) check_room_for_blas(threads);
}

}  // namespace tactile::model
