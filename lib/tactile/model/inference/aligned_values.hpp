#pragma once

#include <cstddef>
#include <new>
#include <vector>

namespace tactile::model {

inline constexpr std::size_t cache_line = 64;  ///< [B]; also the size of the widest vector

template <class T>
struct CacheLineAllocator {
  using value_type = T;

  CacheLineAllocator() = default;
  template <class Other>
  CacheLineAllocator(const CacheLineAllocator<Other>& /*other*/) {}  // NOLINT(google-explicit-constructor): allocators require it

  T* allocate(std::size_t count) { return static_cast<T*>(::operator new (count * sizeof(T), std::align_val_t{cache_line})); }
  void deallocate(T* values, std::size_t /*count*/) { ::operator delete (values, std::align_val_t{cache_line}); }

  friend bool operator==(const CacheLineAllocator&, const CacheLineAllocator&) { return true; }
};

/// A vector that begins at a cache line, as do its copies.
template <class T>
using AlignedValues = std::vector<T, CacheLineAllocator<T>>;

}  // namespace tactile::model
