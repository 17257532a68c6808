#include "tactile/results/delay_table.hpp"

namespace tactile::results {

double DelaySummary::missed_share() const {
  return intervals == 0 ? std::numeric_limits<double>::quiet_NaN()
                        : static_cast<double>(misses + early) / static_cast<double>(intervals);
}

void to_json(nlohmann::json& json, const DelaySummary& summary) {
  json = {{"mean", summary.mean_ms},     {"sem", number_or_null(summary.sem_ms)},
          {"median", summary.median_ms}, {"intervals", summary.intervals},
          {"misses", summary.misses},    {"early", summary.early}};
}

void to_json(nlohmann::json& json, const DelayTable& table) {
  json = table.all;
  json["objects"] = table.objects;
}

void from_json(const JsonView& json, DelaySummary& summary) {
  summary = {json["mean"].get<Figure>(), json["sem"].number(),   json["median"].get<Figure>(),
             json["intervals"].count(),  json["misses"].count(), json["early"].count()};
}

void from_json(const JsonView& json, DelayTable& table) {
  table = {json.get<DelaySummary>(), json["objects"].map_of<DelaySummary>()};
}

}  // namespace tactile::results
