#include "tactile/results/cost_growth.hpp"

namespace tactile::results {
namespace {

nlohmann::json json_of(const GrowthPoint::MethodTime& time) {
  return {{"rendering_us", time.rendering_us}, {"network_us", time.network_us}, {"p50_us", time.p50_us}, {"p99_us", time.p99_us}};
}

GrowthPoint::MethodTime method_time_in(const JsonView& json) {
  return {json["rendering_us"].number(), json["network_us"].number(), json["p50_us"].number(), json["p99_us"].number()};
}

/// 0 by 0 where there is none.
events::SensorSize size_in(const JsonView& json) {
  const auto sides = json.items();
  if (sides.size() != 2) return {};
  return {static_cast<int>(sides[0].whole_number()), static_cast<int>(sides[1].whole_number())};
}

}  // namespace

void to_json(nlohmann::json& json, const GrowthPoint& point) {
  json = {{"events_per_s", point.events_per_s},
          {"th_ms", static_cast<double>(point.history.count()) / 1000},
          {"sensor", {point.sensor.width, point.sensor.height}},
          {"heatmap", {point.heatmap.width, point.heatmap.height}},
          {"lit_share", point.lit_share},
          {"sparse", json_of(point.sparse)},
          {"dense", json_of(point.dense)}};
}

void from_json(const JsonView& json, GrowthPoint& point) {
  point = {.events_per_s = json["events_per_s"].number(),
           .history = json["th_ms"].milliseconds(),
           .sensor = size_in(json["sensor"]),
           .heatmap = size_in(json["heatmap"]),
           .lit_share = json["lit_share"].number(),
           .sparse = method_time_in(json["sparse"]),
           .dense = method_time_in(json["dense"])};
}

void to_json(nlohmann::json& json, const CostGrowth& growth) {
  json = {{"rate", growth.by_rate}, {"history", growth.by_history}, {"resolution", growth.by_resolution}};
}

void from_json(const JsonView& json, CostGrowth& growth) {
  growth = {json["rate"].list_of<GrowthPoint>(), json["history"].list_of<GrowthPoint>(),
            json["resolution"].list_of<GrowthPoint>()};
}

}  // namespace tactile::results
