#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace tactile {

std::string cpu_name();        ///< as the system has it, "unknown" where it has none
std::uint64_t memory_bytes();  ///< of the machine; 0 where it is not known
std::string system_name();     ///< "Linux 6.1.0 x86_64"

/// The free space where a folder is or will be [bytes]; nothing if that cannot be found out.
std::optional<std::uint64_t> free_bytes_at(const std::filesystem::path& folder);

/// Whether the process may take so much more address space. Libraries that need more than the limit (ulimit -v) abort or hang.
bool has_room_for(std::size_t bytes);

/// Whether its address space has a limit (ulimit -v).
bool memory_is_limited();

/// Raises the number of files that the process may have open to `count`, as far as the system allows (ulimit -Hn).
/// @return  how many it may have open now
std::size_t allow_open_files(std::size_t count);

}  // namespace tactile
