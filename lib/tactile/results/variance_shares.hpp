#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "tactile/results/json_view.hpp"

namespace tactile::results {

/// Where the variance of a figure comes from; the sum is 1.
struct VarianceShares {
  double training = 0;  ///< what another training changes for all objects and runs alike; 0 with one training
  double object = 0;    ///< what other objects change for all trainings alike, beyond their runs
  double both = 0;      ///< what another training changes on single objects, beyond their runs; in `object` with one training
  double run = 0;       ///< other runs of the same objects, and the noise of single results; 0 where objects have one run each
};

/// "30 % comes from trainings (alike for all objects), 30 % from objects (alike for all trainings), 20 % from trainings on single
/// objects and 20 % from runs of an object"
std::string words_of(const VarianceShares& shares);

/// {"training", "object", "training_on_object", "run"}
void to_json(nlohmann::json& json, const VarianceShares& shares);
void from_json(const JsonView& json, VarianceShares& shares);

}  // namespace tactile::results
