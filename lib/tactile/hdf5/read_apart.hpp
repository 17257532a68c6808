#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>

#include "tactile/core/error.hpp"

// HDF5 reads beyond its memory when a file's structure is damaged, and then the whole process ends (libhdf5 1.10 and later). So
// bytes of unknown worth are read in a child process first:
//   - A file that is read in any order (a dataset) is walked through by a child, `check_readable`; the parent opens it only if
//     that went well. Files without checksums in their structure are read to the last value there, because a damaged size in an
//     index shows only on reading. Datasets as we write them have such checksums (`create_file`): HDF5 finds the damage by
//     itself, and the walk visits their structure alone.
//   - A file that is read once from its begin to its end (a recording of another program) is read by the child alone, which
//     passes on what it reads: a read that is wrong without a crash in the child harms no parent.
// A child that does not come to its end, whatever the reason, means that the file is damaged: limits on its time and memory end
// loops and made-up sizes.
namespace tactile::hdf5 {

/// A file that is no sound HDF5.
class Damaged : public Error {
 public:
  using Error::Error;
};

/// Passes something on to the parent: two numbers of the caller's own, and bytes.
using Send = std::function<void(std::uint32_t kind, std::uint32_t number, std::span<const std::byte> bytes)>;
using Take = Send;

/// Calls `work` in a process of its own, and `take` in this one, in the same order, with whatever `work` sends. `work` may use
/// HDF5, memory and exceptions, but no other thread, no lock of another thread's and no output. Not within `work` itself.
/// @throws Error, Damaged  as `work` does; Damaged also if its process crashes, or takes more than 20 s of computing and 1 s for
///                         each 4 MiB of `file`, or 2 GiB of memory
void read_apart(const std::filesystem::path& file, const std::function<void(const Send& send)>& work, const Take& take = {});

/// Whether this is the process in which `work` is called.
bool is_apart();

/// Walks through the file in a process of its own: all groups, links, tables and attributes, but no other file that it links to.
/// A file is walked through once in a process, as long as it does not change.
/// @throws Damaged  if that does not come to its end
/// @throws Error    if the file cannot be opened for another reason
void check_readable(const std::filesystem::path& file);

}  // namespace tactile::hdf5
