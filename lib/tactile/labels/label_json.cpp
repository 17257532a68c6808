#include "tactile/labels/label_json.hpp"

#include <algorithm>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"

namespace tactile::labels {
namespace {

using nlohmann::json;

constexpr std::size_t most_history_bytes = std::size_t{3} << 20;  // as compact JSON: half of what the indented file may take

json json_of(const std::optional<CameraTime>& t) { return t ? json(us_of(*t)) : json(nullptr); }

void add_time(json& object, const std::string& name, const alignment::UncertainTime& time) {
  object[name + "_us"] = us_of(time.at);
  object[name + "_low_us"] = us_of(time.low);
  object[name + "_high_us"] = us_of(time.high);
}

alignment::UncertainTime uncertain_time_in(const json& object, const std::string& name, const std::string& where) {
  const auto at = [&](const std::string& key) { return camera_time(member<std::int64_t>(object, key, where)); };
  return {at(name + "_us"), at(name + "_low_us"), at(name + "_high_us")};
}

/// Press or slip: no other class is labelled.
Touch touch_in(const json& object, const std::string& where) {
  const auto name = member<std::string>(object, "class", where);
  for (const Touch touch : {Touch::press, Touch::slip}) {
    if (name == name_of(touch)) return touch;
  }
  throw Error(where + ": class '" + name + "' is not a class of labels; expected press or slip");
}

/// @param one  reads an element of the lists
template <class T, class Read>
ListChange<T> change_in(const json& object, const char* key, const std::string& where, const Read& one) {
  const json change = member<json>(object, key, where);
  ListChange<T> result{.at = member<std::size_t>(change, "at", where), .removed = {}, .added = {}};
  for (const json& element : list_in(change, "removed", where)) result.removed.push_back(one(element, where));
  for (const json& element : list_in(change, "added", where)) result.added.push_back(one(element, where));
  return result;
}

template <class T, class Write>
json json_of_change(const ListChange<T>& change, const Write& one) {
  json object = {{"at", change.at}, {"removed", json::array()}, {"added", json::array()}};
  for (const T& element : change.removed) object["removed"].push_back(one(element));
  for (const T& element : change.added) object["added"].push_back(one(element));
  return object;
}

json json_of(const HistoryEntry& entry) {
  json object = {{"who", entry.who}, {"when", entry.when}, {"what", entry.what}, {"why", entry.why}, {"replaced", nullptr}};
  if (!entry.change) return object;
  object["replaced"] = {
      {"intervals", json_of_change(entry.change->intervals, [](const LabelledInterval& one) { return labels::json_of(one); })},
      {"flags", json_of_change(entry.change->flags, [](const LabelFlag& one) { return labels::json_of(one); })},
      {"rejected", json_of_change(entry.change->rejected, [](const TouchInterval& one) { return json_of_rejected(one); })}};
  return object;
}

HistoryEntry entry_in(const json& object, const std::string& where) {
  HistoryEntry entry{.who = member<std::string>(object, "who", where),
                     .when = member<std::string>(object, "when", where),
                     .what = member<std::string>(object, "what", where),
                     .why = member<std::string>(object, "why", where),
                     .change = std::nullopt};
  const json replaced = member<json>(object, "replaced", where);
  if (replaced.is_null()) return entry;
  entry.change = {.intervals = change_in<LabelledInterval>(replaced, "intervals", where, interval_in),
                  .flags = change_in<LabelFlag>(replaced, "flags", where, flag_in),
                  .rejected = change_in<TouchInterval>(replaced, "rejected", where, rejected_in)};
  return entry;
}

}  // namespace

std::optional<CameraTime> time_in(const json& object, const char* key, const std::string& where) {
  const auto found = object.find(key);
  if (found == object.end() || found->is_null()) return std::nullopt;
  return camera_time(member<std::int64_t>(object, key, where));
}

json list_in(const json& object, const char* key, const std::string& where) {
  json list = member<json>(object, key, where);
  if (!list.is_array()) throw Error(where + ": '" + key + "' is no list; expected a list");
  return list;
}

TouchInterval stretch_in(const json& object, Touch touch, const std::string& where) {
  return {touch, camera_time(member<std::int64_t>(object, "start_us", where)),
          camera_time(member<std::int64_t>(object, "end_us", where))};
}

LabelledInterval interval_in(const json& object, const std::string& where) {
  LabelledInterval interval{.id = object.contains("id") ? member<std::string>(object, "id", where) : std::string(),
                            .touch = touch_in(object, where),
                            .start = uncertain_time_in(object, "start", where),
                            .end = uncertain_time_in(object, "end", where),
                            .source = member<std::string>(object, "source", where),
                            .evidence = {},
                            .confirmed = member<bool>(object, "confirmed", where)};
  if (object.contains("probability")) interval.probability = member<double>(object, "probability", where);
  interval.visible = time_in(object, "visible_us", where);
  const auto evidence = member<json>(object, "evidence", where);
  interval.evidence = {time_in(evidence, "events_us", where), time_in(evidence, "robot_us", where),
                       time_in(evidence, "video_us", where), time_in(evidence, "imu_us", where)};
  return interval;
}

json json_of(const LabelledInterval& interval) {
  json entry = {{"id", interval.id},
                {"class", name_of(interval.touch)},
                {"source", interval.source},
                {"confirmed", interval.confirmed},
                {"evidence",
                 {{"events_us", json_of(interval.evidence.events)},
                  {"robot_us", json_of(interval.evidence.robot)},
                  {"video_us", json_of(interval.evidence.video)},
                  {"imu_us", json_of(interval.evidence.imu)}}}};
  if (interval.probability) entry["probability"] = *interval.probability;
  if (interval.visible) entry["visible_us"] = us_of(*interval.visible);
  add_time(entry, "start", interval.start);
  add_time(entry, "end", interval.end);
  return entry;
}

json json_of(const LabelFlag& flag) {
  return {{"interval", flag.interval_index ? json(*flag.interval_index) : json(nullptr)},
          {"reason", flag.reason},
          {"confirmed", flag.confirmed},
          {"key", flag.key}};
}

LabelFlag flag_in(const json& flag, const std::string& where) {
  const json index = flag.contains("interval") ? member<json>(flag, "interval", where) : json(nullptr);
  if (!index.is_null() && !index.is_number_unsigned())
    throw Error(where + ": a flag's 'interval' is no index; expected one from 0, or null");
  return {.interval_index = index.is_null() ? std::nullopt : std::optional(index.get<std::size_t>()),
          .reason = member<std::string>(flag, "reason", where),
          .confirmed = flag.contains("confirmed") && member<bool>(flag, "confirmed", where),
          .key = flag.contains("key") ? member<std::string>(flag, "key", where) : std::string()};
}

json json_of_rejected(const TouchInterval& rejected) {
  return {{"class", name_of(rejected.touch)}, {"start_us", us_of(rejected.start)}, {"end_us", us_of(rejected.end)}};
}

TouchInterval rejected_in(const json& object, const std::string& where) {
  return stretch_in(object, touch_in(object, where), where);
}

json json_of(const EditHistory& history) {
  std::vector<json> newest_first;
  std::size_t bytes = 0;
  for (std::size_t left = history.entries.size(); left > 0; --left) {
    json object = json_of(history.entries[left - 1]);
    bytes += object.dump(-1, ' ', false, json::error_handler_t::replace).size();
    if (bytes > most_history_bytes || newest_first.size() == most_history_entries) break;
    newest_first.push_back(std::move(object));
  }
  json entries = json::array();
  for (std::size_t left = newest_first.size(); left > 0; --left) entries.push_back(std::move(newest_first[left - 1]));
  return {{"undone", std::min(history.undone, entries.size())}, {"entries", std::move(entries)}};
}

EditHistory history_in(const json& object, const std::string& where) {
  const json entries = list_in(object, "entries", where + ": history");
  if (entries.size() > most_history_entries) {
    throw Error(where + ": its history has " + std::to_string(entries.size()) + " edits; expected at most " +
                std::to_string(most_history_entries));
  }
  EditHistory history{.entries = {}, .undone = member<std::size_t>(object, "undone", where + ": history")};
  for (const json& entry : entries) history.entries.push_back(entry_in(entry, where + ": history"));
  if (history.undone > history.entries.size())
    throw Error(where + ": its history has more edits undone than there are; expected at most " +
                std::to_string(history.entries.size()));
  return history;
}

}  // namespace tactile::labels
