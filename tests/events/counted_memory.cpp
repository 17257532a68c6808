#include "events/counted_memory.hpp"

#include <cstdlib>
#include <new>

namespace tactile::test {
std::atomic<std::size_t> memory_requests{0};
std::atomic<std::size_t> largest_memory_request{0};
}  // namespace tactile::test

void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  ++tactile::test::memory_requests;
  std::size_t largest = tactile::test::largest_memory_request;
  while (size > largest && !tactile::test::largest_memory_request.compare_exchange_weak(largest, size)) {
  }
  return std::malloc(size == 0 ? 1 : size);
}
void* operator new(std::size_t size) {
  if (void* memory = operator new(size, std::nothrow)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, const std::nothrow_t&) noexcept { std::free(memory); }
