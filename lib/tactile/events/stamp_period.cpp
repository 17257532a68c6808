#include "tactile/events/stamp_period.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numeric>
#include <unsupported/Eigen/FFT>

namespace tactile::events {
namespace {

constexpr std::uint64_t fewest_differences = 50;
constexpr double shortest_us = 20, longest_us = 15'000;

/// coherence of the frequencies i / (2 * (size - 1)) per us
std::vector<double> coherence_of(std::span<const std::uint64_t> differences, double total) {
  constexpr std::size_t length = std::size_t{1} << 17;
  std::vector<float> counts(length);
  std::transform(differences.begin(), differences.end(), counts.begin(),
                 [](std::uint64_t count) { return static_cast<float>(count); });
  std::vector<std::complex<float>> spectrum;
  Eigen::FFT<float> fft;
  fft.SetFlag(Eigen::FFT<float>::HalfSpectrum);
  fft.fwd(spectrum, counts);
  std::vector<double> coherence(spectrum.size());
  std::transform(spectrum.begin(), spectrum.end(), coherence.begin(),
                 [&](const std::complex<float>& value) { return static_cast<double>(value.real()) / total; });
  return coherence;
}

double refined(std::span<const std::uint64_t> differences, double period) {
  for (int step = 0; step < 5; ++step) {
    double products = 0, squares = 0;
    for (std::size_t d = 1; d < differences.size(); ++d) {
      if (differences[d] == 0) continue;
      const auto difference = static_cast<double>(d);
      const double k = std::nearbyint(difference / period);
      if (k < 1 || std::abs(difference - k * period) > period / 4) continue;
      products += static_cast<double>(differences[d]) * k * difference;
      squares += static_cast<double>(differences[d]) * k * k;
    }
    if (squares > 0) period = products / squares;
  }
  return period;
}

std::uint64_t total_of(std::span<const std::uint64_t> differences) {
  return std::accumulate(differences.begin(), differences.end(), std::uint64_t{0});
}

}  // namespace

std::optional<double> common_period(std::span<const std::uint64_t> differences) {
  constexpr double least_coherence = 0.9, near_the_greatest = 0.95, most_between = 0.02, most_within = 0.5;
  const std::uint64_t total = total_of(differences);
  if (total < fewest_differences) return std::nullopt;
  const std::vector<double> coherence = coherence_of(differences, static_cast<double>(total));
  const double per_us = 1.0 / (2.0 * static_cast<double>(coherence.size() - 1));
  const auto lowest = static_cast<std::size_t>(1 / longest_us / per_us);
  const auto highest = static_cast<std::size_t>(1 / shortest_us / per_us);
  std::vector<std::uint64_t> up_to(differences.size());
  std::partial_sum(differences.begin(), differences.end(), up_to.begin());
  const auto is_period = [&](std::size_t i) {
    if (coherence[i] < least_coherence || coherence[i] < coherence[i - 1] || coherence[i] < coherence[i + 1]) return false;
    const double period = 1 / (static_cast<double>(i) * per_us);
    const auto up_to_share = [&](double share) {
      return static_cast<double>(up_to[std::min(static_cast<std::size_t>(share * period), up_to.size() - 1)]);
    };
    const double within = up_to_share(0.1), between = up_to_share(0.6) - within;
    return within <= most_within * static_cast<double>(total) && between <= most_between * static_cast<double>(total);
  };
  double greatest = 0;
  for (std::size_t i = lowest; i <= highest; ++i) {
    if (is_period(i)) greatest = std::max(greatest, coherence[i]);
  }
  if (greatest < least_coherence) return std::nullopt;
  for (std::size_t i = lowest; i <= highest; ++i) {
    if (is_period(i) && coherence[i] >= near_the_greatest * greatest)
      return refined(differences, 1 / (static_cast<double>(i) * per_us));
  }
  return std::nullopt;
}

std::optional<double> shortest_period(std::span<const std::uint64_t> differences) {
  constexpr double least_us = 10.0;  // shorter: every event has its own time, there are no read-outs
  std::vector<std::uint64_t> up_to(differences.size());
  std::partial_sum(differences.begin(), differences.end(), up_to.begin());
  const std::uint64_t total = up_to.back();
  if (total < fewest_differences) return std::nullopt;

  const auto last_index = static_cast<double>(differences.size() - 1);
  const auto share_between = [&](double low, double high) {  // both included; low >= 1
    const auto below = static_cast<std::size_t>(std::ceil(low)) - 1;
    return up_to[static_cast<std::size_t>(std::min(high, last_index))] - up_to[below];
  };
  const auto median_between = [&](double low, double high) {
    const auto below = up_to[static_cast<std::size_t>(std::ceil(low)) - 1];
    const std::uint64_t middle = below + (share_between(low, high) + 1) / 2;
    return static_cast<double>(std::lower_bound(up_to.begin(), up_to.end(), middle) - up_to.begin());
  };
  for (std::size_t first = 1; first < differences.size(); ++first) {
    const auto low = static_cast<double>(first);
    if (20 * share_between(low, low * 1.05 / 0.95) < total) continue;
    // Coming from below, the window holds only the lower part of the cluster. It follows its own median into the middle.
    double period = median_between(low, low * 1.05 / 0.95);
    for (int step = 0; step < 100; ++step) {
      const double next = median_between(std::max(1.0, 0.95 * period), 1.05 * period);
      if (next == period) break;
      period = next;
    }
    return period > least_us ? std::optional(period) : std::nullopt;
  }
  return std::nullopt;
}

}  // namespace tactile::events
