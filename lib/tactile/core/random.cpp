#include "tactile/core/random.hpp"

#include <cmath>
#include <numbers>
#include <string>

#include "tactile/core/sha256.hpp"

namespace tactile {

std::uint64_t Random::below(std::uint64_t count) {
  const std::uint64_t unfair = (0 - count) % count;  // 2^64 mod count: these values would be too frequent by one
  std::uint64_t value = engine_();
  while (value < unfair) value = engine_();
  return value % count;
}

double Random::normal() {
  const double radius = std::sqrt(-2.0 * std::log1p(-uniform()));
  return radius * std::cos(2.0 * std::numbers::pi * uniform());
}

double Random::exponential() { return -std::log1p(-uniform()); }

std::uint64_t Random::poisson(double mean) {
  if (mean > 256.0) {  // a normal distribution is indistinguishable here
    const double drawn = std::round(mean + std::sqrt(mean) * normal());
    return drawn > 0.0 ? static_cast<std::uint64_t>(drawn) : 0;
  }
  std::uint64_t count = 0;
  for (double product = uniform(), limit = std::exp(-mean); product > limit; product *= uniform()) ++count;
  return count;
}

std::uint64_t seed_for(std::uint64_t seed, std::initializer_list<std::string_view> names) {
  std::string text = std::to_string(seed);
  for (const std::string_view name : names) {
    text += '\n';
    text += name;
  }
  return std::stoull(sha256_of(text).substr(0, 16), nullptr, 16);
}

}  // namespace tactile
