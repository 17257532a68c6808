#include "tactile/model/definition/trees_options.hpp"

#include <fmt/core.h>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/touch.hpp"

namespace tactile::model {

void to_json(nlohmann::json& json, const TreesOptions& options) {
  json = {{"rounds", options.rounds}, {"depth", options.depth}, {"learning_rate", options.learning_rate}};
}

void from_json(const nlohmann::json& json, TreesOptions& options) {
  const std::string where = "settings of trees";
  options.rounds = member<unsigned>(json, "rounds", where);
  options.depth = member<unsigned>(json, "depth", where);
  options.learning_rate = member<double>(json, "learning_rate", where);
}

void check(const TreesOptions& options) {
  if (options.rounds >= 1 && options.rounds <= 10'000 && options.depth >= 1 && options.depth <= 8 && options.learning_rate > 0 &&
      options.learning_rate <= 1)
    return;
  throw Error(
      fmt::format("trees: {} rounds of depth {} with a learning rate of {}; expected 1 to 10000, 1 to 8, and above 0 to 1",
                  options.rounds, options.depth, options.learning_rate));
}

std::vector<ParameterShape> tree_parameters(const TreesOptions& options) {
  const std::int64_t rounds = options.rounds, answers = std::int64_t{1} << options.depth;
  constexpr auto classes = static_cast<std::int64_t>(touch_count);
  return {{"trees.feature", {rounds, classes, answers - 1}},
          {"trees.threshold", {rounds, classes, answers - 1}},
          {"trees.answer", {rounds, classes, answers}}};
}

}  // namespace tactile::model
