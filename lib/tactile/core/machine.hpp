#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace tactile {

std::string cpu_name();        ///< as the system has it, "unknown" where it has none
std::uint64_t memory_bytes();  ///< of the machine; 0 where it is not known
std::string system_name();     ///< "Linux 6.1.0 x86_64"

/// Whether the process may take so much more address space. Libraries that need more than the limit (ulimit -v) abort or hang.
bool has_room_for(std::size_t bytes);

}  // namespace tactile
