#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "tactile/core/touch.hpp"
#include "tactile/events/event.hpp"

namespace tactile::evaluation {

inline constexpr std::size_t feature_count = 9;
using Features = std::array<double, feature_count>;

/// Moments of a heatmap, with H / 255 as weight of every cell and positions as shares of width and height in [0, 1]:
/// share of cells that are not 0, mean, standard deviation, largest value, centre x and y (0.5 where all is 0), variance in x and
/// in y, covariance of x and y.
/// @param heatmap  [height, width], row by row
/// @throws Error  if its size is not width * height, or that is 0
Features moments_of(std::span<const std::uint8_t> heatmap, events::SensorSize size);

/// Always the touch that is most frequent in training; the earlier one of equals.
struct MajorityBaseline {
  Touch touch = Touch::none;
};

/// @throws Error  if `truth` is empty
MajorityBaseline fit_majority(std::span<const Touch> truth);

/// Two thresholds on the number of events in t_h: below `low`, from there to below `high`, and from there on.
struct EventCountBaseline {
  double low = 0, high = 0;
  std::array<Touch, 3> touches{};

  Touch verdict(std::uint64_t events) const;
};

/// The thresholds and touches that predict the most training samples correctly, found exactly; the lowest thresholds of equals.
/// Thresholds lie half-way between counts that occur.
/// @throws Error  if there is no sample, or not one count for each
EventCountBaseline fit_event_count(std::span<const std::uint64_t> events, std::span<const Touch> truth);

/// Multinomial logistic regression on standardised features; none's logit is 0.
struct LogisticBaseline {
  Features mean{}, deviation{};  ///< of the training samples; a feature that never varies has deviation 1
  std::array<std::array<double, feature_count + 1>, touch_count - 1> weights{};  ///< of press and slip; the last one is the bias

  std::array<double, touch_count> probabilities(const Features& features) const;
  Touch verdict(const Features& features) const;  ///< the likeliest; the earlier one of equals
};

struct LogisticOptions {
  double ridge = 1e-4;  ///< times half the sum of squared weights, added to the mean loss, > 0: keeps separable samples finite
  double tolerance = 1e-8;       ///< of the gradient's largest element, > 0
  std::size_t iterations = 200;  ///< at most
};

/// Minimises mean cross-entropy plus ridge by Newton's method with step halving. The minimum is unique, the result deterministic.
/// @throws Error  if there is no sample, or no features for each
LogisticBaseline fit_logistic(std::span<const Features> features, std::span<const Touch> truth,
                              const LogisticOptions& options = {});

}  // namespace tactile::evaluation
