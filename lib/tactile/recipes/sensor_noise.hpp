#pragma once

#include <filesystem>
#include <vector>

namespace tactile::recipes {

/// The noise of a sensor's pixels, for `noise` and `hot-pixels`.
struct SensorNoise {
  double spread_decades = 0;               ///< between ordinary pixels, standard deviation of log10 of the rate, 0 to 2
  double regularity = 1;                   ///< shape of the gamma distribution of a pixel's intervals, 0.1 to 100; 1: Poisson
  double on_share = 0.5;                   ///< of the events, 0 to 1
  double on_spread = 0;                    ///< between pixels, standard deviation of that share, 0 to 0.45
  std::vector<double> hot_hz{100};         ///< rates of hot pixels [1/s]: quantiles at equal steps, ascending, 1e-3 to 1e6
  std::vector<double> hot_on_shares{0.5};  ///< of a hot pixel's events: quantiles at equal steps, ascending, 0 to 1
  double hot_regularity = 0;               ///< share of a hot pixel's interval that is fixed, 0 to 1

  friend bool operator==(const SensorNoise&, const SensorNoise&) = default;
};

template <class Fields>
void list_fields(Fields& fields, SensorNoise& noise) {
  fields("spread_decades", noise.spread_decades, 0, 2);
  fields("regularity", noise.regularity, 0.1, 100);
  fields("on_share", noise.on_share, 0, 1);
  fields("on_spread", noise.on_spread, 0, 0.45);
  fields("hot_hz", noise.hot_hz, 1e-3, 1e6);
  fields("hot_on_shares", noise.hot_on_shares, 0, 1);
  fields("hot_regularity", noise.hot_regularity, 0, 1);
}

/// The noise that a `sensor.json` of `tactile characterise` has. Values beyond a range are held at its end. Without hot and warm
/// pixels, their rates are those of `measured_noise`.
/// @throws Error  that names the file and the member
SensorNoise read_sensor_noise(const std::filesystem::path& file);

/// The noise of the simulator's camera `measured`, a real DVXplorer: docs/simulation.md has the measurement.
const SensorNoise& measured_noise();

}  // namespace tactile::recipes
