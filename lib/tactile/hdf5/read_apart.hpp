#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>

#include "tactile/core/error.hpp"

// If a file's structure is damaged, HDF5 (libhdf5 1.10 and later) may read outside its memory, which ends the whole process.
// Therefore a child process reads untrusted files first:
//   - A file that is read in any order (a dataset) is visited by a child, `check_readable`. The parent opens it only after
//   success.
//     Of files without checksums in their structure the child reads every value, because a damaged size in an index shows only on
//     reading. Our datasets have such checksums (`create_file`): HDF5 detects damage itself, and the child visits only the
//     structure.
//   - A file that is read once from start to end (a recording of another program) is read only by the child, which sends the
//   values.
//     So an unnoticed bad access in the child cannot harm the parent.
// If the child does not finish, for any reason, the file is damaged. Limits on time and memory end loops and invalid sizes. Only
// if this process is itself limited to less memory, a lack of it says nothing about the file: then std::bad_alloc is thrown.
// The child is a fork of this process without an exec, so no `ChildProcess`: what it runs is a function with what that captures,
// and a program of its own would have to be found wherever the library is used.
namespace tactile::hdf5 {

/// A file that is not sound HDF5.
class Damaged : public Error {
 public:
  using Error::Error;
};

/// Sends two numbers, whose meaning the caller defines, and bytes to the parent.
using Send = std::function<void(std::uint32_t kind, std::uint32_t number, std::span<const std::byte> bytes)>;
using Take = Send;

/// Calls `work` in a child process, and `take` in this one with everything that `work` sends, in the same order. `work` may use
/// HDF5, memory and exceptions, but no other threads, no locks of other threads, no output, and not `read_apart` itself.
/// @throws Error, Damaged  as `work`; Damaged also if the child crashes, or needs more than 20 s of CPU time plus 1 s for each 4
/// MiB of
///                         `file`, or more than 2 GiB of memory
void read_apart(const std::filesystem::path& file, const std::function<void(const Send& send)>& work, const Take& take = {});

/// Whether this is the child process that calls `work`.
bool is_apart();

/// Visits all groups, links, tables and attributes of the file in a child process, but not the files that it links to. An
/// unchanged file is visited only once per process.
/// @throws Damaged  if that does not finish
/// @throws Error    if the file cannot be opened for another reason
void check_readable(const std::filesystem::path& file);

}  // namespace tactile::hdf5
