#include "tactile/results/false_alarm_table.hpp"

#include <cmath>

namespace tactile::results {
namespace {

microseconds minutes_in(const JsonView& json) { return microseconds{std::llround(60e6 * json.number_if_there().value_or(0))}; }

}  // namespace

double in_minutes(microseconds time) { return static_cast<double>(time.count()) / 60e6; }

FalseAlarms& FalseAlarms::operator+=(const FalseAlarms& other) {
  alarms += other.alarms;
  after_intervals += other.after_intervals;
  releases += other.releases;
  unlabelled += other.unlabelled;
  none_time += other.none_time;
  after_intervals_time += other.after_intervals_time;
  releases_time += other.releases_time;
  unlabelled_time += other.unlabelled_time;
  return *this;
}

std::optional<double> FalseAlarms::per_min() const {
  if (none_time <= microseconds{0}) return std::nullopt;
  return static_cast<double>(alarms) / in_minutes(none_time);
}

void to_json(nlohmann::json& json, const FalseAlarmTable& table) {
  json = {{"count", table.total.alarms},
          {"none_min", in_minutes(table.total.none_time)},
          {"per_min", table.per_min},
          {"objects", table.objects},
          {"after_intervals", {{"count", table.total.after_intervals}, {"min", in_minutes(table.total.after_intervals_time)}}},
          {"releases", {{"count", table.total.releases}, {"min", in_minutes(table.total.releases_time)}}},
          {"unlabelled", {{"count", table.total.unlabelled}, {"min", in_minutes(table.total.unlabelled_time)}}}};
}

void from_json(const JsonView& json, FalseAlarmTable& table) {
  const JsonView after = json["after_intervals"], releases = json["releases"], unlabelled = json["unlabelled"];
  table = {.per_min = json["per_min"].get<Figure>(),
           .objects = json["objects"].map_of<Figure>(),
           .total = {.alarms = json["count"].count(),
                     .after_intervals = after["count"].count(),
                     .releases = releases["count"].count(),
                     .unlabelled = unlabelled["count"].count(),
                     .none_time = minutes_in(json["none_min"]),
                     .after_intervals_time = minutes_in(after["min"]),
                     .releases_time = minutes_in(releases["min"]),
                     .unlabelled_time = minutes_in(unlabelled["min"])}};
}

}  // namespace tactile::results
