#include "tactile/results/delay_table.hpp"

namespace tactile::results {

void to_json(nlohmann::json& json, const CensoredQuantile& quantile) {
  json = quantile.ms;
  json["is_lower_bound"] = quantile.is_lower_bound;
}

void from_json(const JsonView& json, CensoredQuantile& quantile) {
  if (json) quantile = {json.get<Figure>(), json["is_lower_bound"].truth()};
}

double DelaySummary::missed_share() const {
  return intervals == 0 ? std::numeric_limits<double>::quiet_NaN()
                        : static_cast<double>(misses + early) / static_cast<double>(intervals);
}

void to_json(nlohmann::json& json, const DetectedWithin& point) { json = {{"ms", point.ms}, {"share", point.share}}; }

void from_json(const JsonView& json, DetectedWithin& point) { point = {json["ms"].number(), json["share"].get<Figure>()}; }

void to_json(nlohmann::json& json, const DelaySummary& summary) {
  json = {{"mean", summary.mean_ms},
          {"sem", number_or_null(summary.sem_ms)},
          {"median", summary.median_ms},
          {"intervals", summary.intervals},
          {"misses", summary.misses},
          {"early", summary.early},
          {"head_starts", summary.head_starts},
          {"missed", summary.missed},
          {"median_of_all", summary.median_of_all_ms},
          {"p90_of_all", summary.quantile_of_all_ms}};
}

void to_json(nlohmann::json& json, const DelayTable& table) {
  json = table.all;
  json["objects"] = table.objects;
  json["detected_within"] = table.curve;
}

void from_json(const JsonView& json, DelaySummary& summary) {
  summary = {.mean_ms = json["mean"].get<Figure>(),
             .sem_ms = json["sem"].number(),
             .median_ms = json["median"].get<Figure>(),
             .intervals = json["intervals"].count(),
             .misses = json["misses"].count(),
             .early = json["early"].count(),
             .head_starts = json["head_starts"].count(),
             .missed = json["missed"].get<Figure>(),
             .median_of_all_ms = json["median_of_all"].get<CensoredQuantile>(),
             .quantile_of_all_ms = json["p90_of_all"].get<CensoredQuantile>()};
}

void from_json(const JsonView& json, DelayTable& table) {
  table = {json.get<DelaySummary>(), json["objects"].map_of<DelaySummary>(), json["detected_within"].list_of<DetectedWithin>()};
}

}  // namespace tactile::results
