#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <random>
#include <string_view>
#include <utility>
#include <vector>

namespace tactile {

/// Random numbers that are the same on every machine for the same seed; the distributions of <random> are not.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  std::uint64_t bits() { return engine_(); }
  double uniform() { return static_cast<double>(engine_() >> 11) * 0x1.0p-53; }  ///< in [0, 1)
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  std::uint64_t below(std::uint64_t count);  ///< in [0, count), every value alike; count > 0
  double normal();                           ///< mean 0, standard deviation 1
  double exponential();                      ///< mean 1
  std::uint64_t poisson(double mean);        ///< mean >= 0

  template <class T>
  void shuffle(std::vector<T>& values) {
    for (std::size_t i = values.size(); i > 1; --i) std::swap(values[i - 1], values[below(i)]);
  }

 private:
  std::mt19937_64 engine_;
};

/// A seed of its own for each use: the same for the same seed and names, unrelated for any others.
std::uint64_t seed_for(std::uint64_t seed, std::initializer_list<std::string_view> names);

}  // namespace tactile
