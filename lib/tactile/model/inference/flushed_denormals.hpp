#pragma once

#include <cstdint>
#if defined(__x86_64__)
#include <xmmintrin.h>
#endif

namespace tactile::model {

/// While it exists, denormal numbers (below 1.2e-38) are 0 in the calculations of its thread. Otherwise each of them takes over a
/// hundred cycles, and a bundle of tiny weights takes minutes. No logit of usual weights changes.
class FlushedDenormals {
 public:
  FlushedDenormals() { write(before_ | flush); }
  ~FlushedDenormals() { write(before_); }
  FlushedDenormals(const FlushedDenormals&) = delete;
  FlushedDenormals& operator=(const FlushedDenormals&) = delete;

 private:
#if defined(__x86_64__)
  static constexpr std::uint64_t flush = 0x8040;  ///< results and operands, bits 15 and 6 of MXCSR
  static std::uint64_t read() { return _mm_getcsr(); }
  static void write(std::uint64_t control) { _mm_setcsr(static_cast<unsigned>(control)); }
#elif defined(__aarch64__)
  static constexpr std::uint64_t flush = std::uint64_t{1} << 24;  ///< FZ of FPCR
  static std::uint64_t read() {
    std::uint64_t control = 0;
    asm volatile("mrs %0, fpcr" : "=r"(control));
    return control;
  }
  static void write(std::uint64_t control) { asm volatile("msr fpcr, %0" : : "r"(control)); }
#else
  static constexpr std::uint64_t flush = 0;
  static std::uint64_t read() { return 0; }
  static void write(std::uint64_t) {}
#endif

  const std::uint64_t before_ = read();
};

}  // namespace tactile::model
