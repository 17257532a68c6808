#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tactile/core/ticks.hpp"
#include "tactile/core/touch.hpp"
#include "tactile/results/json_view.hpp"

namespace tactile::results {

/// What a model predicts at every full tick of a run; one entry for each tick.
struct FullRun {
  std::string run{};  ///< "fan/03"; may be empty
  TickRange ticks{};
  std::vector<Touch> verdicts{};                                ///< the likeliest, before the decision
  std::vector<std::array<float, touch_count>> probabilities{};  ///< of none, press, slip
  std::vector<std::uint64_t> events{};                          ///< in [t_c - t_h, t_c)
  std::size_t close = 0;  ///< ticks of logits so close that another engine may give another verdict; not in JSON
};

/// {"run", "first_us", "tick_us", "predicted": "0012", "probabilities": "3f800000…", "events": []}; the
/// probabilities of none, press and slip of each tick are float32, in 8 hexadecimal digits each
void to_json(nlohmann::json& json, const FullRun& run);
void from_json(const JsonView& json, FullRun& run);

}  // namespace tactile::results
