#include "tactile/recipes/sensor_noise.hpp"

#include <algorithm>

#include "tactile/core/json.hpp"
#include "tactile/core/robust_statistics.hpp"
#include "tactile/simulation/physics.hpp"

namespace tactile::recipes {
namespace {

double value_in(const nlohmann::json& json, std::string_view key, const std::string& where, double low, double high) {
  return std::clamp(member<double>(member<nlohmann::json>(json, key, where), "value", where + ", " + std::string(key)), low,
                    high);
}

/// Quantiles at 21 equal steps, each within the range; fewer values as they are.
std::vector<double> quantiles_of(const std::vector<double>& values, double low, double high) {
  constexpr std::size_t steps = 20;
  std::vector<double> quantiles;
  for (std::size_t i = 0; i <= steps; ++i)
    quantiles.push_back(std::clamp(quantile(values, static_cast<double>(i) / steps), low, high));
  return quantiles;
}

}  // namespace

SensorNoise read_sensor_noise(const std::filesystem::path& file) {
  const nlohmann::json json = read_json(file);
  const std::string where = file.string();
  const auto background = member<nlohmann::json>(json, "background", where);
  SensorNoise noise = measured_noise();
  const double on_hz = value_in(background, "on_hz", where, 0, 1e9), off_hz = value_in(background, "off_hz", where, 0, 1e9);
  if (on_hz + off_hz > 0) noise.on_share = on_hz / (on_hz + off_hz);
  noise.spread_decades = value_in(background, "spread_decades", where, 0, 2);
  noise.regularity = value_in(background, "regularity", where, 0.1, 100);
  noise.on_spread = value_in(background, "on_spread", where, 0, 0.45);

  const auto unusual = member<nlohmann::json>(json, "unusual_pixels", where);
  std::vector<double> rates, shares;
  for (const nlohmann::json& pixel : member<std::vector<nlohmann::json>>(unusual, "pixels", where)) {
    if (member<std::string>(pixel, "kind", where) == "stuck") continue;
    rates.push_back(value_in(pixel, "rate_hz", where, 1e-3, 1e6));
    shares.push_back(member<double>(pixel, "on_share", where));
  }
  if (rates.empty()) return noise;
  noise.hot_hz = quantiles_of(rates, 1e-3, 1e6);
  noise.hot_on_shares = quantiles_of(shares, 0, 1);
  noise.hot_regularity = value_in(unusual, "regularity", where, 0, 1);
  return noise;
}

const SensorNoise& measured_noise() {
  static const SensorNoise noise = [] {
    const simulation::EventCameraOptions camera = simulation::with_camera("measured").camera;
    return SensorNoise{.spread_decades = camera.background_spread_decades,
                       .regularity = camera.background_regularity,
                       .on_share = camera.background_on_share,
                       .on_spread = camera.background_on_spread,
                       .hot_hz = camera.hot_hz,
                       .hot_on_shares = camera.hot_on_shares,
                       .hot_regularity = camera.hot_regularity};
  }();
  return noise;
}

}  // namespace tactile::recipes
