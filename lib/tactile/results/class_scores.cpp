#include "tactile/results/class_scores.hpp"

namespace tactile::results {
namespace {

nlohmann::json json_of(const ClassScore& score) {
  return {{"precision", score.precision}, {"recall", score.recall}, {"f1", score.f1}};
}

ClassScore score_in(const JsonView& json) {
  return {json["precision"].get<Figure>(), json["recall"].get<Figure>(), json["f1"].get<Figure>()};
}

}  // namespace

void to_json(nlohmann::json& json, const ClassScores& scores) {
  json = nlohmann::json::object();
  for (const Touch touch : all_touches) {
    const auto index = static_cast<std::size_t>(touch);
    nlohmann::json of_class = json_of(scores.all[index]);
    of_class["objects"] = nlohmann::json::object();
    for (const auto& [name, of_object] : scores.objects) of_class["objects"][name] = json_of(of_object[index]);
    json[std::string(name_of(touch))] = of_class;
  }
}

void from_json(const JsonView& json, ClassScores& scores) {
  for (const Touch touch : all_touches) {
    const auto index = static_cast<std::size_t>(touch);
    const JsonView of_class = json[name_of(touch)];
    scores.all[index] = score_in(of_class);
    for (const auto& [name, of_object] : of_class["objects"].members()) scores.objects[name][index] = score_in(of_object);
  }
}

}  // namespace tactile::results
