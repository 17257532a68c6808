#include "tactile/results/unseen_comparison.hpp"

namespace tactile::results {

void to_json(nlohmann::json& json, const SeenAndHeldOut& of) {
  json = {{"seen", of.seen}, {"held_out", of.held_out}, {"difference", of.difference}};
}

void from_json(const JsonView& json, SeenAndHeldOut& of) {
  of = {json["seen"].get<Figure>(), json["held_out"].get<Figure>(), json["difference"].get<Figure>()};
}

void to_json(nlohmann::json& json, const UnseenComparison::Models& models) {
  json = {{"seen", models.seen}, {"held_out", models.held_out}};
}

void from_json(const JsonView& json, UnseenComparison::Models& models) {
  models = {json["seen"].text(), json["held_out"].text()};
}

void to_json(nlohmann::json& json, const UnseenComparison& comparison) {
  json = {{"runs", comparison.runs}, {"mean", comparison.mean}, {"objects", comparison.objects}};
  if (comparison.models) json["models"] = *comparison.models;
}

void from_json(const JsonView& json, UnseenComparison& comparison) {
  comparison = {json["models"].if_there<UnseenComparison::Models>(), json["runs"].texts(), json["mean"].get<SeenAndHeldOut>(),
                json["objects"].map_of<SeenAndHeldOut>()};
}

}  // namespace tactile::results
