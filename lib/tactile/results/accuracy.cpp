#include "tactile/results/accuracy.hpp"

namespace tactile::results {

void to_json(nlohmann::json& json, const Accuracy& accuracy) { json = {{"mean", accuracy.mean}, {"objects", accuracy.objects}}; }

void from_json(const JsonView& json, Accuracy& accuracy) {
  accuracy = {json["mean"].get<Figure>(), json["objects"].map_of<Figure>()};
}

}  // namespace tactile::results
