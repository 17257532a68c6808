#include "tactile/labels/posterior/motion_evidence.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "tactile/core/random.hpp"

namespace tactile::labels {
namespace {

PlaceCounts counts_of(std::size_t bins, std::uint16_t each = 0) {
  PlaceCounts counts{.begin = camera_time(0), .bin = 1000us};
  counts.counts.assign(bins * PlaceCounts::places, each);
  return counts;
}

/// The formula of the header in long double, but for the division.
long double expected(const PlaceCounts& counts, const PlaceRates& rates, std::size_t bin, std::size_t level) {
  long double sum = 0;
  for (std::size_t place = 0; place < PlaceCounts::places; ++place) {
    const auto n = static_cast<long double>(counts.at(bin)[place]),
               q = static_cast<long double>(rates.quiet[place] * rates.gain_at(bin, place));
    const long double motion = motion_levels[level] * static_cast<long double>(rates.share[place]), mean = q + motion;
    const long double variance = mean + 2 * motion * motion, r = mean * mean / (variance - mean);
    sum += std::lgamma(n + r) - std::lgamma(r) + r * std::log(r / (r + mean)) + n * std::log(mean / (r + mean)) -
           (n * std::log(q) - q);
  }
  return std::max(sum, -200.0L);
}

TEST(MotionEvidence, IsTheNegativeBinomialRelativeToTheQuietRate) {
  PlaceCounts counts = counts_of(40);
  Random random(1);
  for (std::size_t i = 0; i < counts.counts.size(); ++i)
    counts.counts[i] = static_cast<std::uint16_t>(random.poisson(i / PlaceCounts::places < 20 ? 0.4 : 6));
  counts.counts[25 * PlaceCounts::places] = 65535;
  counts.counts[26 * PlaceCounts::places + 3] = 31;
  counts.counts[26 * PlaceCounts::places + 4] = 32;
  std::vector<double> quiet(40, 0.0), moves(40, 0.0);
  std::fill_n(quiet.begin(), 20, 1.0);
  std::fill_n(moves.begin() + 20, 20, 1.0);
  const PlaceRates rates = rates_given(counts, quiet, moves);
  const std::vector<double> evidence = motion_evidence(counts, rates);
  for (std::size_t bin = 0; bin < 40; ++bin) {
    EXPECT_EQ(evidence[bin * motion_levels.size()], 0);
    for (std::size_t level = 1; level < motion_levels.size(); ++level) {
      const auto right = static_cast<double>(expected(counts, rates, bin, level)) / dispersion_of_noise(counts);
      EXPECT_NEAR(evidence[bin * motion_levels.size() + level], right, 1e-6 * (1 + std::abs(right))) << bin << ", " << level;
    }
  }
}

TEST(MotionEvidence, OfSilenceSpeaksAgainstMotion) {
  const PlaceCounts counts = counts_of(500);
  const std::vector<double> evidence = motion_evidence(counts, first_rates(counts));
  for (std::size_t level = 1; level < motion_levels.size(); ++level) EXPECT_LT(evidence[level], 0);
}

TEST(MotionEvidence, FindsTheQuietRateBesideMotion) {
  PlaceCounts counts = counts_of(4000);
  Random random(2);
  for (std::size_t i = 0; i < counts.counts.size(); ++i) {
    const bool moves = i / PlaceCounts::places > 2500;
    counts.counts[i] = static_cast<std::uint16_t>(random.poisson(moves ? 2 : 0.5));
  }
  const PlaceRates rates = first_rates(counts);
  EXPECT_NEAR(std::accumulate(rates.quiet.begin(), rates.quiet.end(), 0.0) / PlaceCounts::places, 0.5, 0.003);
  EXPECT_NEAR(std::accumulate(rates.share.begin(), rates.share.end(), 0.0), 1, 1e-12);
}

TEST(MotionEvidence, CountsLessWherePixelsFlickerTogether) {
  PlaceCounts poisson = counts_of(3000), together = counts_of(3000);
  Random random(3);
  for (std::size_t bin = 0; bin < 3000; ++bin) {
    const double gain = bin / 8 % 2 == 0 ? 0.95 : 1.05;
    for (std::size_t place = 0; place < PlaceCounts::places; ++place) {
      poisson.counts[bin * PlaceCounts::places + place] = static_cast<std::uint16_t>(random.poisson(0.7));
      together.counts[bin * PlaceCounts::places + place] = static_cast<std::uint16_t>(random.poisson(0.7 * gain));
    }
  }
  EXPECT_NEAR(dispersion_of_noise(poisson), 1, 0.25);
  // Neighbours differ by 10 % of 8 x 134 events: by 107, where Poisson's differ by 46 (standard deviation).
  EXPECT_GT(dispersion_of_noise(together), 4);
}

TEST(MotionEvidence, FollowsADriftOfTheNoise) {
  PlaceCounts counts = counts_of(6000);
  Random random(5);
  for (std::size_t i = 0; i < counts.counts.size(); ++i) {
    const bool later = i / PlaceCounts::places >= 3000;
    counts.counts[i] = static_cast<std::uint16_t>(random.poisson(later ? 0.77 : 0.7));
  }
  const std::vector<double> always(6000, 1.0), never(6000, 0.0);
  const PlaceRates rates = rates_given(counts, always, never);
  EXPECT_NEAR(rates.gain[5000] / rates.gain[1000], 1.1, 0.025);
  PlaceRates without = rates;
  without.gain.assign(6000, 1.0);
  EXPECT_GT(log_likelihood_of_quiet(counts, rates), log_likelihood_of_quiet(counts, without));
}

TEST(MotionEvidence, GivesThePlacesOfAMotionTheirShare) {
  PlaceCounts counts = counts_of(200);
  for (std::size_t bin = 100; bin < 200; ++bin) counts.counts[bin * PlaceCounts::places + 7] = 30;
  std::vector<double> quiet(200, 0.0), moves(200, 0.0);
  std::fill_n(quiet.begin(), 100, 1.0);
  std::fill_n(moves.begin() + 100, 100, 1.0);
  const PlaceRates rates = rates_given(counts, quiet, moves);
  EXPECT_GT(rates.share[7], 0.85);
  EXPECT_GT(rates.share[8], 0) << "every place has some";
}

/// A hot pixel doubles the rate of one place after half of the recording; a touch of 2 s shows in another one.
TEST(MotionEvidence, OfSeveralRunsFollowsHotPixelsAndNoTouch) {
  PlaceCounts counts = counts_of(40'000);
  Random random(8);
  for (std::size_t i = 0; i < counts.counts.size(); ++i) {
    const std::size_t bin = i / PlaceCounts::places, place = i % PlaceCounts::places;
    const bool is_hot = place == 7 && bin >= 20'000, is_touched = place == 9 && bin >= 30'000 && bin < 32'000;
    counts.counts[i] = static_cast<std::uint16_t>(random.poisson(is_hot ? 1.0 : is_touched ? 4 : 0.5));
  }
  std::vector<double> quiet(40'000, 1.0), moves(40'000, 0.0);
  std::fill(quiet.begin() + 30'000, quiet.begin() + 32'000, 0.0);
  std::fill(moves.begin() + 30'000, moves.begin() + 32'000, 1.0);
  counts.several_runs = true;
  const PlaceRates rates = rates_given(counts, quiet, moves);
  EXPECT_NEAR(rates.gain_at(30'000, 7) / rates.gain_at(10'000, 7), 2, 0.2);
  EXPECT_NEAR(rates.gain_at(31'000, 9), 1, 0.09);
  const auto evidence_in = [&](std::size_t begin, std::size_t end) {
    const std::vector<double> evidence = motion_evidence(counts, rates);
    double sum = 0;
    for (std::size_t bin = begin; bin < end; ++bin) sum += evidence[bin * motion_levels.size() + 1];
    return sum;
  };
  EXPECT_LT(evidence_in(21'000, 29'000), 0) << "a hot pixel is no motion";
  EXPECT_GT(evidence_in(30'000, 32'000), 1000);
  counts.several_runs = false;
  const PlaceRates of_one = rates_given(counts, quiet, moves);
  EXPECT_EQ(of_one.gain_at(30'000, 7), of_one.gain_at(30'000, 8)) << "in one run all places have one gain";
}

}  // namespace
}  // namespace tactile::labels
