#include "tactile/labels/labels.hpp"

#include <algorithm>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"

namespace tactile {
namespace {

using nlohmann::json;

json json_of(const std::optional<CameraTime>& t) { return t ? json(us_of(*t)) : json(nullptr); }

std::optional<CameraTime> time_in(const json& object, const char* key, const std::string& where) {
  const auto found = object.find(key);
  if (found == object.end() || found->is_null()) return std::nullopt;
  return camera_time(member<std::int64_t>(object, key, where));
}

void add_time(json& object, const std::string& name, const UncertainTime& time) {
  object[name + "_us"] = us_of(time.at);
  object[name + "_low_us"] = us_of(time.low);
  object[name + "_high_us"] = us_of(time.high);
}

UncertainTime uncertain_time_in(const json& object, const std::string& name, const std::string& where) {
  const auto at = [&](const std::string& key) { return camera_time(member<std::int64_t>(object, key, where)); };
  return {at(name + "_us"), at(name + "_low_us"), at(name + "_high_us")};
}

json json_of(const std::optional<FittedClock>& clock) {
  if (!clock) return nullptr;
  json object = clock->relation;
  object["residual_us"] = clock->residual_us;
  object["anchors"] = clock->anchors;
  object["method"] = clock->method;
  return object;
}

json list_in(const json& object, const char* key, const std::string& where) {
  json list = member<json>(object, key, where);
  if (!list.is_array()) throw Error(where + ": '" + key + "' is no list; expected a list");
  return list;
}

std::optional<FittedClock> clock_in(const json& clocks, const char* key, const std::string& where) {
  const auto found = clocks.find(key);
  if (found == clocks.end() || found->is_null()) return std::nullopt;
  return FittedClock{.relation = member<ClockRelation>(clocks, key, where),
                     .residual_us = member<double>(*found, "residual_us", where),
                     .anchors = member<int>(*found, "anchors", where),
                     .method = member<std::string>(*found, "method", where)};
}

LabelledInterval interval_in(const json& object, const std::string& where) {
  LabelledInterval interval{.touch = touch_named(member<std::string>(object, "class", where)),
                            .start = uncertain_time_in(object, "start", where),
                            .end = uncertain_time_in(object, "end", where),
                            .source = member<std::string>(object, "source", where),
                            .evidence = {},
                            .confirmed = member<bool>(object, "confirmed", where)};
  const auto evidence = member<json>(object, "evidence", where);
  interval.evidence = {time_in(evidence, "events_us", where), time_in(evidence, "robot_us", where),
                       time_in(evidence, "video_us", where), time_in(evidence, "imu_us", where)};
  return interval;
}

void check_intervals(const std::vector<LabelledInterval>& intervals, const std::string& where) {
  for (std::size_t i = 0; i < intervals.size(); ++i) {
    if (intervals[i].touch == Touch::none)
      throw Error(where + ": interval " + std::to_string(i) + " is of class none; expected press or slip");
    if (intervals[i].end.at < intervals[i].start.at) {
      throw Error(where + ": interval " + std::to_string(i) + " ends before it starts; expected start_us <= end_us");
    }
    if (i > 0 && intervals[i].start.at < intervals[i - 1].end.at) {
      throw Error(where + ": interval " + std::to_string(i) +
                  " starts before the one ahead of it ends; expected intervals by start that do not overlap");
    }
  }
}

}  // namespace

bool Labels::run_is_flagged() const {
  return std::any_of(flags.begin(), flags.end(), [](const LabelFlag& flag) { return !flag.confirmed && !flag.interval_index; });
}

bool Labels::interval_is_flagged(std::size_t index) const {
  return std::any_of(flags.begin(), flags.end(),
                     [&](const LabelFlag& flag) { return !flag.confirmed && flag.interval_index == index; });
}

Labels read_labels(const std::filesystem::path& file) {
  const json object = read_json(file);
  const std::string where = file.string();
  Labels labels;
  try {
    for (const json& interval : list_in(object, "intervals", where)) labels.intervals.push_back(interval_in(interval, where));
    const auto clocks = member<json>(object, "clocks", where);
    labels.robot_clock = clock_in(clocks, "robot", where);
    labels.video_clock = clock_in(clocks, "video", where);
    for (const json& flag : list_in(object, "flags", where)) {
      const json index = flag.value("interval", json(nullptr));
      if (!index.is_null() && !index.is_number_unsigned())
        throw Error(where + ": a flag's 'interval' is no index; expected one from 0, or null");
      labels.flags.push_back({.interval_index = index.is_null() ? std::nullopt : std::optional(index.get<std::size_t>()),
                              .reason = member<std::string>(flag, "reason", where),
                              .confirmed = flag.value("confirmed", false)});
    }
    labels.provenance = object.value("provenance", json::object());
  } catch (const json::exception& e) {
    throw Error(where + ": not laid out as labels are (" + e.what() + "); expected what 'tactile label' writes");
  }
  check_intervals(labels.intervals, where);
  for (const LabelFlag& flag : labels.flags) {
    if (flag.interval_index && *flag.interval_index >= labels.intervals.size()) {
      throw Error(where + ": a flag names interval " + std::to_string(*flag.interval_index) + " of " +
                  std::to_string(labels.intervals.size()) + "; expected an index from 0");
    }
  }
  return labels;
}

void write_labels(const std::filesystem::path& file, const Labels& labels) {
  check_intervals(labels.intervals, file.string());
  json object = {{"intervals", json::array()},
                 {"clocks", {{"robot", json_of(labels.robot_clock)}, {"video", json_of(labels.video_clock)}}},
                 {"flags", json::array()},
                 {"provenance", labels.provenance}};
  for (const LabelledInterval& interval : labels.intervals) {
    json entry = {{"class", name_of(interval.touch)},
                  {"source", interval.source},
                  {"confirmed", interval.confirmed},
                  {"evidence",
                   {{"events_us", json_of(interval.evidence.events)},
                    {"robot_us", json_of(interval.evidence.robot)},
                    {"video_us", json_of(interval.evidence.video)},
                    {"imu_us", json_of(interval.evidence.imu)}}}};
    add_time(entry, "start", interval.start);
    add_time(entry, "end", interval.end);
    object["intervals"].push_back(std::move(entry));
  }
  for (const LabelFlag& flag : labels.flags) {
    object["flags"].push_back({{"interval", flag.interval_index ? json(*flag.interval_index) : json(nullptr)},
                               {"reason", flag.reason},
                               {"confirmed", flag.confirmed}});
  }
  write_json(file, object);
}

}  // namespace tactile
