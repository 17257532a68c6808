#include "tactile/labels/labels.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "tactile/core/error.hpp"
#include "tactile/core/error_text.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/json_object.hpp"
#include "tactile/core/json_text.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/labels/label_json.hpp"

namespace tactile::labels {
namespace {

using nlohmann::json;

constexpr std::int64_t latest_us = 10'000'000'000'000'000;  // in the year 2286, of a camera that counts from 1970
constexpr double most_drift_ppm = 100'000;                  // as in labels of other tools

/// Whether the recording of the labels has times that no camera gives: below 0, or beyond `latest_us`.
bool has_odd_times(const std::filesystem::path& recording) {
  try {
    const events::RecordingReader reader(recording);
    return std::any_of(reader.packets().begin(), reader.packets().end(), [](const events::PacketRecord& packet) {
      return packet.elements > 0 && (us_of(packet.first) < 0 || us_of(packet.last) > latest_us);
    });
  } catch (const Error&) {
    return false;  // the error appears when its events are read
  }
}

/// Checks that times can be those of a run. Labels lie within their recording. A real one begins at 0 or later; the 95 % interval
/// of an onset may reach below.
class TimeCheck {
 public:
  explicit TimeCheck(std::filesystem::path file) : file_(std::move(file)) {}

  void check(const Labels& labels) const {
    for (std::size_t i = 0; i < labels.intervals.size(); ++i) check_interval(element("intervals", i), labels.intervals[i]);
    for (std::size_t i = 0; i < labels.releases.size(); ++i) check_times(element("releases", i), labels.releases[i]);
    for (std::size_t i = 0; i < labels.rejected.size(); ++i) check_times(element("rejected", i), labels.rejected[i]);
    for (std::size_t i = 0; i < labels.robot_clocks.size(); ++i)
      check_clock(labels.robot_clocks.size() == 1 ? "clocks.robot" : element("clocks.robot", i), labels.robot_clocks[i]);
    if (labels.video_clock) check_clock("clocks.video", *labels.video_clock);
  }

 private:
  static std::string element(const std::string& list, std::size_t index) { return list + "[" + std::to_string(index) + "]"; }

  void check_time(const std::string& member, std::int64_t us, std::int64_t earliest_us) const {
    if (us >= earliest_us && us <= latest_us) return;
    if (!has_odd_times_) has_odd_times_ = has_odd_times(file_.parent_path() / "events.aedat4");
    if (*has_odd_times_) return;
    throw Error(
        fmt::format("{}: {} is {}; expected {} to {}, as its recording has", file_.string(), member, us, earliest_us, latest_us));
  }

  void check_times(const std::string& where, const TouchInterval& times) const {
    check_time(where + ".start_us", us_of(times.start), 0);
    check_time(where + ".end_us", us_of(times.end), 0);
  }

  void check_interval(const std::string& where, const LabelledInterval& interval) const {
    for (const auto& [name, time] : {std::pair(".start", &interval.start), std::pair(".end", &interval.end)}) {
      check_time(where + name + "_us", us_of(time->at), 0);
      check_time(where + name + "_low_us", us_of(time->low), -latest_us);
      check_time(where + name + "_high_us", us_of(time->high), -latest_us);
    }
  }

  void check_clock(const std::string& where, const alignment::FittedClock& clock) const {
    check_time(where + ".offset_us", clock.relation.offset_us, -latest_us);
    if (std::abs(clock.relation.drift_ppm) <= most_drift_ppm) return;
    throw Error(fmt::format("{}: {}.drift_ppm is {}; expected {} to {}", file_.string(), where, clock.relation.drift_ppm,
                            -most_drift_ppm, most_drift_ppm));
  }

  std::filesystem::path file_;
  mutable std::optional<bool> has_odd_times_;  ///< read once, where a time asks for it
};

json json_of(const alignment::FittedClock& clock) {
  json object = clock.relation;
  object["offset_low_us"] = clock.offset_low_us;
  object["offset_high_us"] = clock.offset_high_us;
  if (clock.drift_within_ppm > 0) {
    object["found_at_us"] = clock.found_at_us;
    object["drift_within_ppm"] = clock.drift_within_ppm;
  }
  object["anchors"] = clock.anchors;
  object["method"] = clock.method;
  if (clock.from) object["from_us"] = us_of(*clock.from);
  if (clock.to) object["to_us"] = us_of(*clock.to);
  return object;
}

/// A clock that ran through is an object, one that started again is a list of its pieces, as `truth.json` has it.
json json_of(const std::vector<alignment::FittedClock>& pieces) {
  if (pieces.empty()) return nullptr;
  if (pieces.size() == 1) return json_of(pieces.front());
  json list = json::array();
  for (const alignment::FittedClock& piece : pieces) list.push_back(json_of(piece));
  return list;
}

alignment::FittedClock clock_in(const json& object, const std::string& where) {
  alignment::FittedClock clock{.relation = {.offset_us = member<std::int64_t>(object, "offset_us", where),
                                            .drift_ppm = member<double>(object, "drift_ppm", where),
                                            .reference_us = member<std::int64_t>(object, "reference_us", where)},
                               .anchors = member<int>(object, "anchors", where),
                               .method = member<std::string>(object, "method", where),
                               .from = time_in(object, "from_us", where),
                               .to = time_in(object, "to_us", where)};
  if (clock.anchors < 0) throw Error(where + ": 'anchors' is below 0; expected 0 or more");
  clock.offset_low_us =
      object.contains("offset_low_us") ? member<std::int64_t>(object, "offset_low_us", where) : clock.relation.offset_us;
  clock.offset_high_us =
      object.contains("offset_high_us") ? member<std::int64_t>(object, "offset_high_us", where) : clock.relation.offset_us;
  if (object.contains("drift_within_ppm")) {
    clock.found_at_us = member<std::int64_t>(object, "found_at_us", where);
    clock.drift_within_ppm = member<double>(object, "drift_within_ppm", where);
  }
  return clock;
}

std::vector<alignment::FittedClock> clocks_in(const json& clocks, const char* key, const std::string& where) {
  const auto found = clocks.find(key);
  if (found == clocks.end() || found->is_null()) return {};
  if (!found->is_array()) return {clock_in(*found, where + ": clocks." + key)};
  std::vector<alignment::FittedClock> pieces;
  for (const json& piece : *found) pieces.push_back(clock_in(piece, where + ": clocks." + key));
  return pieces;
}

void check_intervals(const std::vector<LabelledInterval>& intervals, const std::string& where) {
  std::set<std::string> ids;
  for (std::size_t i = 0; i < intervals.size(); ++i) {
    if (intervals[i].touch == Touch::none)
      throw Error(where + ": interval " + std::to_string(i) + " is of class none; expected press or slip");
    if (!ids.insert(intervals[i].id).second)
      throw Error(where + ": two intervals are called '" + intervals[i].id + "'; expected ids of their own");
    if (intervals[i].end.at < intervals[i].start.at) {
      throw Error(where + ": interval " + std::to_string(i) + " ends before it starts; expected start_us <= end_us");
    }
    if (i > 0 && intervals[i].start.at < intervals[i - 1].end.at) {
      throw Error(where + ": interval " + std::to_string(i) +
                  " starts before the one before it ends; expected intervals by start that do not overlap");
    }
  }
}

}  // namespace

const alignment::FittedClock* Labels::robot_clock_of(RobotTime first_stamp) const {
  const auto found = std::find_if(robot_clocks.begin(), robot_clocks.end(), [&](const alignment::FittedClock& clock) {
    return clock.relation.reference_us == us_of(first_stamp);
  });
  return found == robot_clocks.end() ? nullptr : &*found;
}

const alignment::FittedClock* Labels::robot_clock_at(CameraTime t) const {
  const alignment::FittedClock* nearest = nullptr;
  microseconds least = microseconds::max();
  for (const alignment::FittedClock& clock : robot_clocks) {
    const microseconds too_early = clock.from && t < *clock.from ? between(t, *clock.from) : 0us;
    const microseconds too_late = clock.to && t > *clock.to ? between(*clock.to, t) : 0us;
    if (nearest == nullptr || std::max(too_early, too_late) < least) {
      nearest = &clock;
      least = std::max(too_early, too_late);
    }
  }
  return nearest;
}

std::vector<TouchInterval> unclear_motion(const Labels& labels) {
  std::vector<TouchInterval> unclear = labels.releases;
  for (const LabelledInterval& interval : labels.intervals)
    if (interval.end.high > interval.end.at) unclear.push_back({Touch::none, interval.end.at, interval.end.high});
  return unclear;
}

std::string touches_sha256(const Labels& labels) {
  nlohmann::json intervals = nlohmann::json::array(), releases = nlohmann::json::array();
  for (std::size_t i = 0; i < labels.intervals.size(); ++i) {
    const LabelledInterval& interval = labels.intervals[i];
    intervals.push_back({name_of(interval.touch), us_of(interval.start.at), us_of(interval.start.low), us_of(interval.start.high),
                         us_of(interval.end.at), us_of(interval.end.low), us_of(interval.end.high),
                         labels.interval_is_flagged(i)});
  }
  for (const TouchInterval& release : labels.releases) releases.push_back({us_of(release.start), us_of(release.end)});
  return sha256_of(json_text({{"flagged", labels.run_is_flagged()}, {"intervals", intervals}, {"releases", releases}}));
}

void cut_overlaps(std::vector<LabelledInterval>& intervals) {
  for (std::size_t i = 0; i + 1 < intervals.size(); ++i) {
    alignment::UncertainTime& end = intervals[i].end;
    const CameraTime next = intervals[i + 1].start.at;
    end = {std::min(end.at, next), std::min(end.low, next), std::min(end.high, next)};
  }
}

void name_intervals(std::vector<LabelledInterval>& intervals) {
  std::set<std::string> taken;
  for (const LabelledInterval& interval : intervals) taken.insert(interval.id);
  for (LabelledInterval& interval : intervals) {
    for (int number = 1; interval.id.empty(); ++number) {
      const std::string id = std::string(name_of(interval.touch)) + "-" + std::to_string(number);
      if (taken.insert(id).second) interval.id = id;
    }
  }
}

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
  check_object(object, where + ":");
  Labels labels;
  try {
    for (const json& interval : list_in(object, "intervals", where)) labels.intervals.push_back(interval_in(interval, where));
    const auto clocks = member<json>(object, "clocks", where);
    labels.robot_clocks = clocks_in(clocks, "robot", where);
    const std::vector<alignment::FittedClock> video = clocks_in(clocks, "video", where);
    if (video.size() > 1) throw Error(where + ": clocks.video is a list; expected one clock, or null");
    if (!video.empty()) labels.video_clock = video.front();
    if (object.contains("remarks")) labels.remarks = member<std::vector<std::string>>(object, "remarks", where);
    if (object.contains("releases")) {
      for (const json& release : list_in(object, "releases", where))
        labels.releases.push_back(stretch_in(release, Touch::none, where));
    }
    if (object.contains("rejected")) {
      for (const json& rejected : list_in(object, "rejected", where)) labels.rejected.push_back(rejected_in(rejected, where));
    }
    for (const json& flag : list_in(object, "flags", where)) labels.flags.push_back(flag_in(flag, where));
    if (object.contains("history")) labels.history = history_in(member<json>(object, "history", where), where);
    labels.provenance = object.value("provenance", json::object());
  } catch (const json::exception& e) {
    throw Error(where + ": not laid out as labels are (a value " + plain_words(e.what()) +
                "); expected what 'tactile label' writes");
  }
  name_intervals(labels.intervals);
  check_intervals(labels.intervals, where);
  TimeCheck(file).check(labels);
  for (const LabelFlag& flag : labels.flags) {
    if (flag.interval_index && *flag.interval_index >= labels.intervals.size()) {
      throw Error(where + ": a flag names interval " + std::to_string(*flag.interval_index) + " of " +
                  std::to_string(labels.intervals.size()) + "; expected an index from 0");
    }
  }
  return labels;
}

void write_labels(const std::filesystem::path& file, const Labels& labels) {
  std::vector<LabelledInterval> intervals = labels.intervals;
  name_intervals(intervals);
  check_intervals(intervals, file.string());
  json object = {
      {"intervals", json::array()},
      {"clocks",
       {{"robot", json_of(labels.robot_clocks)}, {"video", labels.video_clock ? json_of(*labels.video_clock) : json(nullptr)}}},
      {"flags", json::array()},
      {"releases", json::array()},
      {"remarks", labels.remarks},
      {"rejected", json::array()},
      {"provenance", labels.provenance}};
  for (const LabelledInterval& interval : intervals) object["intervals"].push_back(json_of(interval));
  for (const LabelFlag& flag : labels.flags) object["flags"].push_back(json_of(flag));
  for (const TouchInterval& release : labels.releases)
    object["releases"].push_back({{"start_us", us_of(release.start)}, {"end_us", us_of(release.end)}});
  for (const TouchInterval& rejected : labels.rejected) object["rejected"].push_back(json_of_rejected(rejected));
  if (!labels.history.entries.empty()) object["history"] = json_of(labels.history);
  write_json(file, object);
}

}  // namespace tactile::labels
