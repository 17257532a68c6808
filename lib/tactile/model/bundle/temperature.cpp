#include "tactile/model/bundle/temperature.hpp"

#include <fmt/core.h>

#include <cmath>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"

namespace tactile::model {

std::filesystem::path temperature_file(const ModelBundle& bundle) { return bundle.folder / "temperature.json"; }

void to_json(nlohmann::json& json, const Temperature& temperature) {
  json = {{"value", temperature.value},           {"fitted_on", nlohmann::json::array()},
          {"samples", temperature.samples},       {"loss_before", temperature.loss_before},
          {"loss_after", temperature.loss_after}, {"weights_sha256", temperature.weights_sha256}};
  for (const LearnedRun& run : temperature.fitted_on) json["fitted_on"].push_back(run);
}

void from_json(const nlohmann::json& json, Temperature& temperature) {
  const std::string where = "temperature.json";
  temperature = {.value = member<double>(json, "value", where),
                 .fitted_on = {},
                 .samples = member<std::uint64_t>(json, "samples", where),
                 .loss_before = member<double>(json, "loss_before", where),
                 .loss_after = member<double>(json, "loss_after", where),
                 .weights_sha256 = member<std::string>(json, "weights_sha256", where)};
  for (const auto& run : member<std::vector<nlohmann::json>>(json, "fitted_on", where))
    temperature.fitted_on.push_back(learned_run_in(run, where));
}

Temperature read_temperature(const ModelBundle& bundle, const ModelDescription& description) {
  if (description.own) return {.value = description.own->temperature};
  const std::filesystem::path file = temperature_file(bundle);
  if (!std::filesystem::exists(file)) return {};
  Temperature temperature;
  try {
    temperature = read_json(file).get<Temperature>();
  } catch (const Error& e) {
    throw Error(bundle.folder.string() + ": " + e.what());
  }
  if (!(temperature.value > 0) || !std::isfinite(temperature.value))
    throw Error(fmt::format("{}: a temperature of {}; expected one above 0", file.string(), temperature.value));
  if (temperature.weights_sha256 != description.weights_sha256) {
    throw Error(file.string() +
                ": was fitted to other weights; expected the bundle as it was written: run 'tactile train --calibrate' again");
  }
  return temperature;
}

void write_temperature(const ModelBundle& bundle, const Temperature& temperature) {
  write_json(temperature_file(bundle), temperature);
}

bool fitted_on(const Temperature& temperature, const windows::DatasetRun& run) {
  return contains_recording(temperature.fitted_on, learned_run_of(run));
}

}  // namespace tactile::model
