#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "tactile/model/bundle/model_bundle.hpp"
#include "tactile/model/inference/classifier.hpp"

namespace tactile::evaluation {

/// Processor time that a model takes for a tick of a live stream on this machine: events counted, input made, network run.
struct TickSpeed {
  double us_p50 = 0, us_p99 = 0;  ///< of half and of 99 % of the ticks at most
  std::uint64_t ticks = 0;
};

/// {"us_p50", "us_p99", "ticks"}
void to_json(nlohmann::json& json, const TickSpeed& speed);

/// Follows the first `most_ticks` ticks of a recording as `detect` does, as fast as possible.
/// @return  nothing if the recording is shorter than the history
/// @throws Error  if it cannot be read, or is of another sensor
std::optional<TickSpeed> measure_tick_speed(const std::filesystem::path& recording, const model::Classifier& classifier,
                                            std::uint64_t most_ticks = 2000);

/// The file in a bundle that has the speed that `eval` measured last.
inline std::filesystem::path speed_file(const model::ModelBundle& bundle) { return bundle.results() / "speed.json"; }

}  // namespace tactile::evaluation
