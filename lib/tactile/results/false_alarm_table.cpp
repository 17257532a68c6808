#include "tactile/results/false_alarm_table.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace tactile::results {
namespace {

microseconds minutes_in(const JsonView& json) { return microseconds{std::llround(60e6 * json.number_if_there().value_or(0))}; }

std::optional<double> share(microseconds part, microseconds time) {
  if (time <= microseconds{0}) return std::nullopt;
  return static_cast<double>(part.count()) / static_cast<double>(time.count());
}

std::optional<double> rate(std::uint64_t count, microseconds time) {
  if (time <= microseconds{0}) return std::nullopt;
  return static_cast<double>(count) / in_minutes(time);
}

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
  outside_labels += other.outside_labels;
  outside_labels_time += other.outside_labels_time;
  outside_labels_in_alarm += other.outside_labels_in_alarm;
  outside_motion += other.outside_motion;
  outside_motion_time += other.outside_motion_time;
  outside_motion_in_alarm += other.outside_motion_in_alarm;
  none_in_alarm += other.none_in_alarm;
  wrong_class += other.wrong_class;
  wrong_class_time += other.wrong_class_time;
  labelled_time += other.labelled_time;
  tick = std::max(tick, other.tick);
  return *this;
}

std::optional<double> FalseAlarms::per_min() const { return rate(alarms, none_time); }
std::optional<double> FalseAlarms::outside_labels_per_min() const { return rate(outside_labels, outside_labels_time); }
std::optional<double> FalseAlarms::outside_motion_per_min() const { return rate(outside_motion, outside_motion_time); }
std::optional<double> FalseAlarms::wrong_class_per_min() const { return rate(wrong_class, labelled_time); }
std::optional<double> FalseAlarms::outside_labels_share() const { return share(outside_labels_in_alarm, outside_labels_time); }
std::optional<double> FalseAlarms::outside_motion_share() const { return share(outside_motion_in_alarm, outside_motion_time); }
std::optional<double> FalseAlarms::none_in_alarm_share() const { return share(none_in_alarm, none_time); }
std::optional<double> FalseAlarms::wrong_class_share() const { return share(wrong_class_time, labelled_time); }

void to_json(nlohmann::json& json, const FalseAlarmTable& table) {
  json = {{"count", table.total.alarms},
          {"none_min", in_minutes(table.total.none_time)},
          {"per_min", table.per_min},
          {"objects", table.objects},
          {"after_intervals", {{"count", table.total.after_intervals}, {"min", in_minutes(table.total.after_intervals_time)}}},
          {"releases", {{"count", table.total.releases}, {"min", in_minutes(table.total.releases_time)}}},
          {"unlabelled", {{"count", table.total.unlabelled}, {"min", in_minutes(table.total.unlabelled_time)}}},
          {"outside_labels",
           {{"count", table.total.outside_labels},
            {"min", in_minutes(table.total.outside_labels_time)},
            {"per_min", table.outside_labels_per_min},
            {"alarm_min", in_minutes(table.total.outside_labels_in_alarm)},
            {"share", table.outside_labels_share}}},
          {"outside_motion",
           {{"count", table.total.outside_motion},
            {"min", in_minutes(table.total.outside_motion_time)},
            {"per_min", table.outside_motion_per_min},
            {"alarm_min", in_minutes(table.total.outside_motion_in_alarm)},
            {"share", table.outside_motion_share}}},
          {"none_in_alarm", {{"min", in_minutes(table.total.none_in_alarm)}, {"share", table.none_in_alarm_share}}},
          {"wrong_class",
           {{"count", table.total.wrong_class},
            {"wrong_min", in_minutes(table.total.wrong_class_time)},
            {"min", in_minutes(table.total.labelled_time)},
            {"per_min", table.wrong_class_per_min},
            {"share", table.wrong_class_share}}}};
}

void from_json(const JsonView& json, FalseAlarmTable& table) {
  const JsonView after = json["after_intervals"], releases = json["releases"], unlabelled = json["unlabelled"];
  const JsonView outside = json["outside_labels"], outside_motion = json["outside_motion"];
  const JsonView in_alarm = json["none_in_alarm"], wrong_class = json["wrong_class"];
  table = {.per_min = json["per_min"].get<Figure>(),
           .objects = json["objects"].map_of<Figure>(),
           .outside_labels_per_min = outside["per_min"].get<Figure>(),
           .outside_motion_per_min = outside_motion["per_min"].get<Figure>(),
           .wrong_class_per_min = wrong_class["per_min"].get<Figure>(),
           .outside_labels_share = outside["share"].get<Figure>(),
           .outside_motion_share = outside_motion["share"].get<Figure>(),
           .none_in_alarm_share = in_alarm["share"].get<Figure>(),
           .wrong_class_share = wrong_class["share"].get<Figure>(),
           .total = {.alarms = json["count"].count(),
                     .after_intervals = after["count"].count(),
                     .releases = releases["count"].count(),
                     .unlabelled = unlabelled["count"].count(),
                     .none_time = minutes_in(json["none_min"]),
                     .after_intervals_time = minutes_in(after["min"]),
                     .releases_time = minutes_in(releases["min"]),
                     .unlabelled_time = minutes_in(unlabelled["min"]),
                     .outside_labels = outside["count"].count(),
                     .outside_labels_time = minutes_in(outside["min"]),
                     .outside_labels_in_alarm = minutes_in(outside["alarm_min"]),
                     .outside_motion = outside_motion["count"].count(),
                     .outside_motion_time = minutes_in(outside_motion["min"]),
                     .outside_motion_in_alarm = minutes_in(outside_motion["alarm_min"]),
                     .none_in_alarm = minutes_in(in_alarm["min"]),
                     .wrong_class = wrong_class["count"].count(),
                     .wrong_class_time = minutes_in(wrong_class["wrong_min"]),
                     .labelled_time = minutes_in(wrong_class["min"])}};
}

void to_json(nlohmann::json& json, const FalseAlarms& of_run) {
  json = {{"count", of_run.alarms},
          {"after_intervals", of_run.after_intervals},
          {"releases", of_run.releases},
          {"unlabelled", of_run.unlabelled},
          {"none_min", in_minutes(of_run.none_time)},
          {"none_in_alarm_min", in_minutes(of_run.none_in_alarm)},
          {"after_intervals_min", in_minutes(of_run.after_intervals_time)},
          {"releases_min", in_minutes(of_run.releases_time)},
          {"unlabelled_min", in_minutes(of_run.unlabelled_time)},
          {"outside_labels", of_run.outside_labels},
          {"outside_labels_min", in_minutes(of_run.outside_labels_time)},
          {"outside_labels_alarm_min", in_minutes(of_run.outside_labels_in_alarm)},
          {"outside_motion", of_run.outside_motion},
          {"outside_motion_min", in_minutes(of_run.outside_motion_time)},
          {"outside_motion_alarm_min", in_minutes(of_run.outside_motion_in_alarm)},
          {"wrong_class", of_run.wrong_class},
          {"wrong_min", in_minutes(of_run.wrong_class_time)},
          {"labelled_min", in_minutes(of_run.labelled_time)},
          {"tick_us", of_run.tick.count()}};
}

void from_json(const JsonView& json, FalseAlarms& of_run) {
  of_run = {.alarms = json["count"].count(),
            .after_intervals = json["after_intervals"].count(),
            .releases = json["releases"].count(),
            .unlabelled = json["unlabelled"].count(),
            .none_time = minutes_in(json["none_min"]),
            .after_intervals_time = minutes_in(json["after_intervals_min"]),
            .releases_time = minutes_in(json["releases_min"]),
            .unlabelled_time = minutes_in(json["unlabelled_min"]),
            .outside_labels = json["outside_labels"].count(),
            .outside_labels_time = minutes_in(json["outside_labels_min"]),
            .outside_labels_in_alarm = minutes_in(json["outside_labels_alarm_min"]),
            .outside_motion = json["outside_motion"].count(),
            .outside_motion_time = minutes_in(json["outside_motion_min"]),
            .outside_motion_in_alarm = minutes_in(json["outside_motion_alarm_min"]),
            .none_in_alarm = minutes_in(json["none_in_alarm_min"]),
            .wrong_class = json["wrong_class"].count(),
            .wrong_class_time = minutes_in(json["wrong_min"]),
            .labelled_time = minutes_in(json["labelled_min"]),
            .tick = microseconds{std::llround(json["tick_us"].number_if_there().value_or(0))}};
}

std::string words_of(const FalseAlarms& of_run) {
  const auto counted = [](std::uint64_t episodes, std::optional<double> per_min) {
    return std::to_string(episodes) + (per_min ? fmt::format(" ({:.1f} per minute)", *per_min) : "");
  };
  std::string words = "False alarms outside labels: " + counted(of_run.outside_labels, of_run.outside_labels_per_min());
  // Without the run's true motion there is no time outside of it.
  if (const auto per_min = of_run.outside_motion_per_min())
    words += "; without unlabelled motion: " + counted(of_run.outside_motion, per_min);
  if (const auto share = of_run.none_in_alarm_share()) words += fmt::format("; {:.1f} % of none time in alarm", 100 * *share);
  return words + ". Episodes of the wrong class: " + counted(of_run.wrong_class, of_run.wrong_class_per_min()) + ".";
}

}  // namespace tactile::results
