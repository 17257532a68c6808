#include "tactile/results/evaluation.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "tactile/core/error.hpp"
#include "tactile/core/version.hpp"

namespace tactile::results {

void to_json(nlohmann::json& json, const Evaluation& evaluation) {
  Evaluation copy = evaluation;
  MemberWriter members;
  list_members(members, copy);
  json = members.json();
  json["title"] = title_of(evaluation);
  json["software"] = {{"name", "tactile"}, {"version", version()}, {"revision", revision()}};
  json["model"] = evaluation.models.front();
  json["classes"] = nlohmann::json::array();
  for (const Touch touch : all_touches) json["classes"].push_back(name_of(touch));
  json["test_runs"] = evaluation.test_runs();
  json["false_alarms_per_min"] = evaluation.whole_runs.decided.alarms_per_min;
}

void from_json(const JsonView& json, Evaluation& evaluation) {
  MemberReader members(json);
  list_members(members, evaluation);
  if (evaluation.models.empty())
    throw Error(json.where() + ": has no trainings; expected what 'tactile eval' writes, which makes it again");
}

std::vector<std::string> Evaluation::test_runs() const {
  std::vector<std::string> names;
  for (const EvaluatedModel& model : models) names.insert(names.end(), model.test_runs.begin(), model.test_runs.end());
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

std::string title_of(const Evaluation& evaluation) {
  const std::size_t more = evaluation.models.size() - 1;
  return fmt::format("Evaluation of {}{} on {} runs", evaluation.models.front().name,
                     more == 0   ? std::string()
                     : more == 1 ? std::string(" and another training")
                                 : fmt::format(" and {} more trainings", more),
                     evaluation.simulated ? "simulated" : "real");
}

}  // namespace tactile::results
