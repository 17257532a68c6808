#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tactile/model/bundle/model_bundle.hpp"

namespace tactile::model {

/// What the logits are divided by before they become probabilities: above 1 the network is less sure, below 1 more. The verdict
/// stays the same. A bundle without `temperature.json` has 1.
/// Source: Guo et al., On Calibration of Modern Neural Networks, ICML 2017, section 4.2.
struct Temperature {
  double value = 1;                     ///< > 0
  std::vector<LearnedRun> fitted_on{};  ///< no figure may be measured on these
  std::uint64_t samples = 0;            ///< of them
  double loss_before = 0;               ///< mean cross-entropy of the samples [nats], with a temperature of 1
  double loss_after = 0;                ///< with this one
  std::string weights_sha256{};         ///< of the weights that it was fitted to
};

/// {"value", "fitted_on": [{"run", "events_sha256", "event_digest"}], "samples", "loss_before", "loss_after", "weights_sha256"}
void to_json(nlohmann::json& json, const Temperature& temperature);
void from_json(const nlohmann::json& json, Temperature& temperature);  ///< @throws Error

std::filesystem::path temperature_file(const ModelBundle& bundle);  ///< in its folder

/// The bundle's temperature; 1 where it has none.
/// @throws Error  if `temperature.json` is damaged, its value is not above 0, or it was fitted to other weights
Temperature read_temperature(const ModelBundle& bundle, const ModelDescription& description);

void write_temperature(const ModelBundle& bundle, const Temperature& temperature);

/// Whether the temperature was fitted on the recording of this run.
bool fitted_on(const Temperature& temperature, const windows::DatasetRun& run);

}  // namespace tactile::model
