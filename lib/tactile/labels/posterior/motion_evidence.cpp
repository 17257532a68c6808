#include "tactile/labels/posterior/motion_evidence.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <span>

#include "tactile/core/robust_statistics.hpp"

namespace tactile::labels {
namespace {

constexpr double shape = 0.5;          // of the gamma distribution of a place's motion
constexpr double spread_evenly = 0.1;  // part of the shares that is the same for all places

void normalise(std::vector<double>& share) {
  const double sum = std::accumulate(share.begin(), share.end(), 0.0);
  for (double& one : share)
    one = (1 - spread_evenly) * (sum > 0 ? one / sum : 1.0 / PlaceCounts::places) + spread_evenly / PlaceCounts::places;
}

/// The events of all places together, in each whole stretch of `width` bins; in all bins if there are fewer.
std::vector<double> events_by_block(const PlaceCounts& counts, std::size_t width) {
  std::vector<double> sums(std::max<std::size_t>(1, counts.bins() / width), 0.0);
  for (std::size_t b = 0; b < std::min(counts.bins(), sums.size() * width); ++b) {
    for (const std::uint16_t n : counts.at(b)) sums[b / width] += n;
  }
  return sums;
}

/// Whether all of these bins were.
bool is_recorded(const PlaceCounts& counts, std::size_t begin, std::size_t end) {
  for (std::size_t b = begin; b < std::min(end, counts.bins()); ++b) {
    if (!counts.is_recorded(b)) return false;
  }
  return true;
}

/// The half of the places whose events grow least by motions.
std::vector<std::size_t> calm_places(const PlaceRates& rates) {
  std::vector<std::size_t> order(PlaceCounts::places);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return rates.share[a] * rates.quiet[b] < rates.share[b] * rates.quiet[a];
  });
  order.resize(PlaceCounts::places / 2);
  return order;
}

/// Of the noise in each bin.
std::vector<double> gain_of_noise(const PlaceCounts& counts, const PlaceRates& rates) {
  constexpr double drift = 0.1, least = 0.8, most = 1.25, step = 0.02;
  constexpr std::size_t around = 2;
  const std::vector<std::size_t> places = calm_places(rates);
  double quiet = 0;
  for (const std::size_t place : places) quiet += rates.quiet[place];
  const auto width = static_cast<std::size_t>(std::max<std::int64_t>(1, 250ms / counts.bin));
  std::vector<double> of_block;
  for (std::size_t begin = 0; begin < counts.bins(); begin += width) {
    const std::size_t end = std::min(counts.bins(), begin + width);
    double sum = 0;
    std::size_t recorded = 0;
    for (std::size_t b = begin; b < end; ++b) {
      if (!counts.is_recorded(b)) continue;
      ++recorded;
      for (const std::size_t place : places) sum += counts.at(b)[place];
    }
    if (recorded == 0) {
      of_block.push_back(of_block.empty() ? 1 : of_block.back());
      continue;
    }
    const double expected = quiet * static_cast<double>(recorded), known = drift * drift / (drift * drift + 1 / (expected + 1));
    of_block.push_back(1 + known * (sum / expected - 1));
  }
  std::vector<double> gain(counts.bins());
  for (std::size_t block = 0; block < of_block.size(); ++block) {
    const std::size_t first = block - std::min(block, around), last = std::min(of_block.size() - 1, block + around);
    const double usual = median(std::span(of_block).subspan(first, last - first + 1));
    const double stepped = step * std::round(std::clamp(usual, least, most) / step);
    std::fill(gain.begin() + static_cast<std::ptrdiff_t>(block * width),
              gain.begin() + static_cast<std::ptrdiff_t>(std::min(counts.bins(), (block + 1) * width)), stepped);
  }
  return gain;
}

/// By the quiet rates.
void set_own_gains(PlaceRates& rates, const PlaceCounts& counts) {
  constexpr microseconds stretch = 500ms;
  constexpr double drift = 0.3, step = 0.04;
  constexpr std::size_t around = 10;
  rates.bins_of_own_gain = static_cast<std::size_t>(std::max<std::int64_t>(1, stretch / counts.bin));
  const std::size_t stretches = (counts.bins() + rates.bins_of_own_gain - 1) / rates.bins_of_own_gain;
  std::vector<double> sums(stretches * PlaceCounts::places, 0.0), recorded(stretches, 0.0);
  for (std::size_t b = 0; b < counts.bins(); ++b) {
    if (!counts.is_recorded(b)) continue;
    const std::size_t at = b / rates.bins_of_own_gain;
    recorded[at] += 1;
    for (std::size_t place = 0; place < PlaceCounts::places; ++place)
      sums[at * PlaceCounts::places + place] += counts.at(b)[place];
  }
  rates.own_gain.assign(sums.size(), 1.0F);
  std::vector<double> near;
  for (std::size_t place = 0; place < PlaceCounts::places; ++place) {
    for (std::size_t at = 0; at < stretches; ++at) {
      near.clear();
      double expected = 0;
      for (std::size_t k = at - std::min(at, around); k < std::min(stretches, at + around + 1); ++k) {
        if (recorded[k] == 0) continue;
        const double usual = rates.quiet[place] * recorded[k], events = sums[k * PlaceCounts::places + place];
        near.push_back(events == 0 && usual < 1 ? 1 : (events + 1.0 / 3) / usual);  // a Poisson median is 1/3 below the mean
        expected += usual;
      }
      if (near.empty()) continue;
      const double known = drift * drift / (drift * drift + std::numbers::pi / 2 / (expected + 1));
      const double gain = std::max(0.05, 1 + known * (median(near) - 1));
      rates.own_gain[at * PlaceCounts::places + place] = static_cast<float>(std::exp(step * std::round(std::log(gain) / step)));
    }
  }
}

/// The negative binomial of one place and level, relative to the quiet Poisson distribution.
class PlaceLevel {
 public:
  PlaceLevel(double quiet, double motion) : mean_(quiet + motion) {
    r_ = std::min(mean_ * mean_ * shape / (motion * motion), 1e6);
    base_ = r_ * std::log(r_ / (r_ + mean_)) + quiet;
    per_event_ = std::log(mean_ / (r_ + mean_)) - std::log(quiet);
    double sum = base_;
    for (std::size_t n = 0; n < known_.size(); ++n) {
      known_[n] = sum;
      sum += std::log(r_ + static_cast<double>(n)) + per_event_;
    }
  }

  double of(std::uint16_t n) const {
    if (n < known_.size()) return known_[n];
    return base_ + std::lgamma(n + r_) - std::lgamma(r_) + n * per_event_;
  }

 private:
  double mean_, r_ = 0, base_ = 0, per_event_ = 0;
  std::array<double, 32> known_{};  ///< lgamma(n + r) - lgamma(r) is a sum of logarithms
};

}  // namespace

PlaceRates first_rates(const PlaceCounts& counts) {
  const auto width = static_cast<std::size_t>(std::max<std::int64_t>(1, 100ms / counts.bin));
  const std::vector<double> sums = events_by_block(counts, width);
  std::vector<std::size_t> order(sums.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::erase_if(order, [&](std::size_t block) { return !is_recorded(counts, block * width, (block + 1) * width); });
  if (order.empty()) order.push_back(0);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return sums[a] < sums[b]; });
  const std::size_t calm = std::max<std::size_t>(std::min<std::size_t>(3, order.size()), order.size() / 3);
  PlaceRates rates{std::vector<double>(PlaceCounts::places, 0.0), std::vector<double>(PlaceCounts::places, 1.0),
                   std::vector<double>(counts.bins(), 1.0)};
  double bins = 0;
  for (std::size_t i = 0; i < calm; ++i) {
    for (std::size_t b = order[i] * width; b < std::min(counts.bins(), (order[i] + 1) * width); ++b, ++bins) {
      const auto row = counts.at(b);
      for (std::size_t place = 0; place < PlaceCounts::places; ++place) rates.quiet[place] += row[place];
    }
  }
  double sum = 0;
  for (double& rate : rates.quiet) rate = (rate + 0.5) / std::max(bins, 1.0), sum += rate;
  const double correction = 1 + 1.09 / std::sqrt(sum * static_cast<double>(width));
  for (double& rate : rates.quiet) rate *= correction;
  if (counts.several_runs) set_own_gains(rates, counts);
  normalise(rates.share);
  return rates;
}

PlaceRates rates_given(const PlaceCounts& counts, std::span<const double> quiet, std::span<const double> moves) {
  PlaceRates rates{std::vector<double>(PlaceCounts::places, 0.5), std::vector<double>(PlaceCounts::places, 0.0),
                   std::vector<double>(counts.bins(), 1.0)};
  double bins = 0;
  for (std::size_t b = 0; b < counts.bins(); ++b) {
    bins += quiet[b];
    for (std::size_t place = 0; place < PlaceCounts::places; ++place) rates.quiet[place] += quiet[b] * counts.at(b)[place];
  }
  for (double& rate : rates.quiet) rate /= std::max(bins, 1.0);
  if (counts.several_runs) set_own_gains(rates, counts);
  for (std::size_t b = 0; b < counts.bins(); ++b) {
    if (moves[b] == 0) continue;
    for (std::size_t place = 0; place < PlaceCounts::places; ++place)
      rates.share[place] += moves[b] * (counts.at(b)[place] - rates.gain_at(b, place) * rates.quiet[place]);
  }
  for (double& share : rates.share) share = std::max(0.0, share);
  if (!counts.several_runs) rates.gain = gain_of_noise(counts, rates);
  normalise(rates.share);
  return rates;
}

double dispersion_of_noise(const PlaceCounts& counts) {
  constexpr double median_of_chi_square = 0.4549;
  const auto width = static_cast<std::size_t>(std::max<std::int64_t>(1, 8ms / counts.bin));
  const std::vector<double> sums = events_by_block(counts, width);
  std::vector<double> squares;
  for (std::size_t i = 1; i < sums.size(); ++i) {
    const double both = sums[i] + sums[i - 1], apart = sums[i] - sums[i - 1];
    if (both > 0) squares.push_back(apart * apart / both);
  }
  return squares.empty() ? 1 : std::max(1.0, median(squares) / median_of_chi_square);
}

double log_likelihood_of_quiet(const PlaceCounts& counts, const PlaceRates& rates) {
  std::vector<double> log_quiet(PlaceCounts::places);
  std::transform(rates.quiet.begin(), rates.quiet.end(), log_quiet.begin(), [](double q) { return std::log(q); });
  double sum = 0;
  for (std::size_t b = 0; b < counts.bins(); ++b) {
    if (!counts.is_recorded(b)) continue;
    const auto row = counts.at(b);
    double log_gain = 0, of_gain = 1;  // places with one gain share its logarithm
    for (std::size_t place = 0; place < PlaceCounts::places; ++place) {
      const double gain = rates.gain_at(b, place);
      if (gain != of_gain) log_gain = std::log(of_gain = gain);
      sum += row[place] * (log_quiet[place] + log_gain) - gain * rates.quiet[place];
    }
  }
  return sum / dispersion_of_noise(counts);
}

std::vector<double> motion_evidence(const PlaceCounts& counts, const PlaceRates& rates) {
  constexpr double least = -200;
  const double dispersion = dispersion_of_noise(counts);
  const double bin_ms = 1e-3 * static_cast<double>(counts.bin.count());
  std::vector<double> evidence(counts.bins() * motion_levels.size(), 0.0);
  for (std::size_t place = 0; place < PlaceCounts::places; ++place) {
    std::map<double, std::vector<PlaceLevel>> levels_of_gain;
    for (std::size_t b = 0; b < counts.bins(); ++b) {
      if (!counts.is_recorded(b)) continue;
      const double gain = rates.gain_at(b, place);
      std::vector<PlaceLevel>& of_level = levels_of_gain[gain];
      for (std::size_t level = of_level.size() + 1; level < motion_levels.size(); ++level)
        of_level.emplace_back(gain * rates.quiet[place], motion_levels[level] * bin_ms * rates.share[place]);
      const std::uint16_t n = counts.at(b)[place];
      double* of_bin = &evidence[b * motion_levels.size()];
      for (std::size_t level = 1; level < motion_levels.size(); ++level) of_bin[level] += of_level[level - 1].of(n);
    }
  }
  for (double& one : evidence) one = std::max(one, least) / dispersion;
  return evidence;
}

}  // namespace tactile::labels
