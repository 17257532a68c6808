#include "tactile/characterise/physics_file.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace tactile::characterise {
namespace {

/// Seven digits: more would only make the file harder to read.
double rounded(double value) {
  if (value == 0 || !std::isfinite(value)) return 0;
  const double scale = std::pow(10.0, 6 - std::floor(std::log10(std::abs(value))));
  return std::nearbyint(value * scale) / scale;
}

double if_seen(const Measured& measured) { return measured.value > 2 * measured.uncertainty ? rounded(measured.value) : 0.0; }

/// At most 21 values, at equal steps from the least to the greatest.
std::vector<double> quantiles_of(std::vector<double> values) {
  constexpr std::size_t most = 21;
  std::sort(values.begin(), values.end());
  std::vector<double> quantiles;
  const std::size_t count = std::min(most, values.size());
  for (std::size_t i = 0; i < count; ++i) {
    const double place = count == 1 ? 0 : static_cast<double>((values.size() - 1) * i) / static_cast<double>(count - 1);
    const auto below = static_cast<std::size_t>(place);
    const double above = values[std::min(below + 1, values.size() - 1)];
    quantiles.push_back(rounded(values[below] + (place - std::floor(place)) * (above - values[below])));
  }
  return quantiles;
}

void put_readout(nlohmann::json& camera, const events::Readout& readout) {
  using Kind = events::Readout::Kind;
  if (readout.kind == Kind::none) return;
  camera["readout_us"] = rounded(readout.period_us.value);
  if (readout.kind != Kind::steady) return;
  const bool columns = readout.scan == events::Scan::columns, rows = readout.scan == events::Scan::rows;
  // There the last line is stamped first.
  camera["scan_us_per_column"] = columns ? rounded(-readout.step_us.value) : 0.0;
  camera["scan_us_per_row"] = rows ? rounded(-readout.step_us.value) : 0.0;
  camera["jitter_us"] = if_seen(readout.jitter_us);
  camera["wander_us"] = if_seen(readout.wander_us);
  if (readout.wander_s > 0) camera["wander_s"] = std::clamp(rounded(readout.wander_s), 1e-3, 1e3);
}

void put_unusual(nlohmann::json& camera, const UnusualPixels& unusual) {
  std::vector<double> rates, on_shares, stuck_shares;
  for (const UnusualPixel& pixel : unusual.pixels) {
    if (pixel.kind == UnusualPixel::Kind::lit) continue;  // light, not the sensor
    if (pixel.kind == UnusualPixel::Kind::stuck) {
      stuck_shares.push_back(pixel.on_share);
      continue;
    }
    rates.push_back(pixel.rate_hz.value);
    on_shares.push_back(pixel.on_share);
  }
  camera["hot_pixels"] = rates.size();
  if (!rates.empty()) {
    camera["hot_hz"] = quantiles_of(rates);
    camera["hot_on_shares"] = quantiles_of(on_shares);
    camera["hot_regularity"] = std::clamp(rounded(unusual.regularity.value), 0.0, 1.0);
  }
  camera["stuck_pixels"] = stuck_shares.size();
  if (!stuck_shares.empty()) camera["stuck_on_share"] = rounded(mean_of(stuck_shares).value);
}

}  // namespace

nlohmann::json physics_of(const Sensor& sensor) {
  const Background& background = sensor.background;
  nlohmann::json camera = {{"preset", "measured"},
                           {"size", {sensor.size.width, sensor.size.height}},
                           {"background_hz", rounded(background.hz())},
                           {"background_on_share", rounded(background.on_share())},
                           {"background_spread_decades", std::min(2.0, rounded(background.spread_decades.value))},
                           {"background_regularity", std::clamp(rounded(background.regularity.value), 0.1, 100.0)},
                           {"background_on_spread", std::min(0.45, rounded(background.on_spread.value))},
                           {"leak_hz", 0},
                           {"shot_hz", 0},
                           {"dead_pixels", static_cast<std::int64_t>(if_seen(sensor.dead.count))}};
  put_readout(camera, sensor.readout);
  put_unusual(camera, sensor.unusual);
  if (sensor.refractory_us) camera["refractory_us"] = static_cast<std::int64_t>(sensor.refractory_us->value);
  std::string why =
      fmt::format("measured by tactile characterise on {} quiet recording{} of {} in {:.3f} s", sensor.quiet.size(),
                  sensor.quiet.size() == 1 ? "" : "s", sensor.camera.empty() ? "a camera" : sensor.camera, sensor.seconds);
  if (sensor.readout.kind == events::Readout::Kind::none) why += "; it has no read-outs, so those of the simulator stay";
  return {{"why", why}, {"camera", camera}, {"sessions", {{"vary", false}}}, {"variation", {{"noise_spread", 0}}}};
}

}  // namespace tactile::characterise
