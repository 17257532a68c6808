#pragma once

#include <mutex>

namespace tactile::hdf5 {

/// Required around all functions of HDF5, and of hdf5_objects.hpp: only one thread may use HDF5 at a time. It also silences HDF5.
/// If memory runs out, HDF5 may call exit (1.10.8 and later). Then std::terminate is called while a std::bad_alloc is handled.
class Session {
 public:
  Session();
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

 private:
  std::unique_lock<std::recursive_mutex> lock_;
};

}  // namespace tactile::hdf5
