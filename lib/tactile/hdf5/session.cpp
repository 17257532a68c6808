#include "tactile/hdf5/session.hpp"

#include <hdf5.h>
#include <unistd.h>

#include <cstdlib>
#include <exception>
#include <new>

#include "tactile/hdf5/read_apart.hpp"

namespace tactile::hdf5 {
namespace {

thread_local int sessions = 0;  ///< of this thread

/// Called at exit. If HDF5 itself called exit, other threads still use it. A child need not say why it ends.
void end_if_hdf5_exits() noexcept {
  if (sessions == 0) return;
  if (is_apart()) ::_exit(1);
  try {
    throw std::bad_alloc();
  } catch (...) {
    std::terminate();
  }
}

}  // namespace

Session::Session() {
  static std::recursive_mutex guard;
  if (!is_apart()) lock_ = std::unique_lock(guard);  // a child process has one thread, and the lock belongs to its parent
  // Every `Id` is closed by its owner. At exit, HDF5 (1.10.8) crashes in a file that could not be written, on a full disk.
  [[maybe_unused]] static const bool leaves_exit_alone = H5dont_atexit() >= 0;
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  [[maybe_unused]] static const int registered = std::atexit(end_if_hdf5_exits);
  ++sessions;
}

Session::~Session() { --sessions; }

}  // namespace tactile::hdf5
