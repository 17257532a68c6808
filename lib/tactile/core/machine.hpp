#pragma once

#include <cstdint>
#include <string>

namespace tactile {

std::string cpu_name();        ///< as the system has it, "unknown" where it has none
std::uint64_t memory_bytes();  ///< of the machine; 0 where it is not known
std::string system_name();     ///< "Linux 6.1.0 x86_64"

}  // namespace tactile
