#include "tactile/results/calibration.hpp"

namespace tactile::results {

void to_json(nlohmann::json& json, const ReliabilityBin& bin) {
  json = {{"from", bin.from},
          {"to", bin.to},
          {"samples", bin.samples},
          {"confidence", number_or_null(bin.confidence)},
          {"accuracy", bin.accuracy}};
}

void from_json(const JsonView& json, ReliabilityBin& bin) {
  bin = {json["from"].number(), json["to"].number(), json["samples"].count(), json["confidence"].number(),
         json["accuracy"].get<Figure>()};
}

void to_json(nlohmann::json& json, const Calibration& calibration) {
  json = {{"ece", calibration.error}, {"objects", calibration.objects}, {"bins", calibration.bins}};
}

void from_json(const JsonView& json, Calibration& calibration) {
  calibration = {json["ece"].get<Figure>(), json["objects"].map_of<Figure>(), json["bins"].list_of<ReliabilityBin>()};
}

}  // namespace tactile::results
