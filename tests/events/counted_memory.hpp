#pragma once

#include <atomic>
#include <cstddef>

namespace tactile::test {

// What this whole test program asks of `operator new`.
extern std::atomic<std::size_t> memory_requests;
extern std::atomic<std::size_t> largest_memory_request;  ///< [B]

}  // namespace tactile::test
