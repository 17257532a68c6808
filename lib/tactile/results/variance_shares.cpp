#include "tactile/results/variance_shares.hpp"

#include <fmt/core.h>

namespace tactile::results {

std::string words_of(const VarianceShares& shares) {
  return fmt::format(
      "{:.0f} % comes from trainings (alike for all objects), {:.0f} % from objects (alike for all trainings), {:.0f} % from "
      "trainings on single objects and {:.0f} % from runs of an object",
      100 * shares.training, 100 * shares.object, 100 * shares.both, 100 * shares.run);
}

void to_json(nlohmann::json& json, const VarianceShares& shares) {
  json = {{"training", shares.training}, {"object", shares.object}, {"training_on_object", shares.both}, {"run", shares.run}};
}

void from_json(const JsonView& json, VarianceShares& shares) {
  shares = {json["training"].number(), json["object"].number(), json["training_on_object"].number(), json["run"].number()};
}

}  // namespace tactile::results
