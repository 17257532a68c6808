#include "tactile/labels/correlation.hpp"

#include <bit>
#include <cmath>
#include <complex>
#include <numbers>
#include <utility>

namespace tactile {
namespace {

using Complex = std::complex<double>;

// Cooley and Tukey's transform in place; the size is a power of two. `turn` is -1 forwards, +1 back (not scaled).
void transform(std::vector<Complex>& values, double turn) {
  const std::size_t n = values.size();
  for (std::size_t i = 1, j = 0; i < n; ++i) {
    std::size_t bit = n >> 1U;
    for (; (j & bit) != 0; bit >>= 1U) j ^= bit;
    j ^= bit;
    if (i < j) std::swap(values[i], values[j]);
  }
  std::vector<Complex> roots(n / 2);
  for (std::size_t i = 0; i < roots.size(); ++i)
    roots[i] = std::polar(1.0, turn * 2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(n));
  for (std::size_t half = 1; half < n; half *= 2) {
    const std::size_t stride = n / (2 * half);
    for (std::size_t begin = 0; begin < n; begin += 2 * half) {
      for (std::size_t i = 0; i < half; ++i) {
        const Complex &even = values[begin + i], &other = values[begin + half + i], &root = roots[i * stride];
        // Written out: the library's product looks for infinities.
        const Complex odd(other.real() * root.real() - other.imag() * root.imag(),
                          other.real() * root.imag() + other.imag() * root.real());
        const Complex sum = even + odd, difference = even - odd;
        values[begin + i] = sum;
        values[begin + half + i] = difference;
      }
    }
  }
}

}  // namespace

std::vector<double> correlations(std::span<const double> a, std::span<const double> b) {
  if (a.empty() || b.empty()) return {};
  const std::size_t lags = a.size() + b.size() - 1, n = std::bit_ceil(lags);
  // Both in one transform: `a` backwards as the real part, `b` as the imaginary one. The product of the two spectra is a quarter
  // of the difference of the squares, i.e. Im(z^2) / 2 in the time domain.
  std::vector<Complex> z(n);
  for (std::size_t i = 0; i < a.size(); ++i) z[a.size() - 1 - i].real(a[i]);
  for (std::size_t i = 0; i < b.size(); ++i) z[i].imag(b[i]);
  transform(z, -1.0);
  for (Complex& value : z) value *= value;
  transform(z, 1.0);
  std::vector<double> result(lags);
  for (std::size_t k = 0; k < lags; ++k) result[k] = 0.5 * z[k].imag() / static_cast<double>(n);
  return result;
}

}  // namespace tactile
