#include "tactile/review/labels_view.hpp"

#include <algorithm>
#include <optional>
#include <string>

namespace tactile::review {
namespace {

using nlohmann::json;

std::int64_t since(CameraTime first, CameraTime t) { return between(first, t).count(); }

json since_or_null(CameraTime first, const std::optional<CameraTime>& t) { return t ? json(since(first, *t)) : json(); }

json view_of(const labels::LabelledInterval& interval, CameraTime first) {
  const labels::Evidence& evidence = interval.evidence;
  return {{"id", interval.id},
          {"touch", name_of(interval.touch)},
          {"start_us", since(first, interval.start.at)},
          {"start_low_us", since(first, interval.start.low)},
          {"start_high_us", since(first, interval.start.high)},
          {"end_us", since(first, interval.end.at)},
          {"end_low_us", since(first, interval.end.low)},
          {"end_high_us", since(first, interval.end.high)},
          {"source", interval.source},
          {"confirmed", interval.confirmed},
          {"onset_evidence",
           {{"events_us", since_or_null(first, evidence.events)},
            {"robot_us", since_or_null(first, evidence.robot)},
            {"video_us", since_or_null(first, evidence.video)},
            {"imu_us", since_or_null(first, evidence.imu)}}}};
}

json stretches_view(const std::vector<TouchInterval>& stretches, CameraTime first, bool with_class) {
  json list = json::array();
  for (const TouchInterval& stretch : stretches) {
    list.push_back({{"start_us", since(first, stretch.start)}, {"end_us", since(first, stretch.end)}});
    if (with_class) list.back()["touch"] = name_of(stretch.touch);
  }
  return list;
}

std::size_t made_edits(const labels::EditHistory& history) {
  return history.entries.size() - std::min(history.undone, history.entries.size());
}

json history_view(const labels::EditHistory& history) {
  json list = json::array();
  for (std::size_t i = 0; i < history.entries.size(); ++i) {
    const labels::HistoryEntry& entry = history.entries[i];
    list.push_back({{"who", entry.who},
                    {"when", entry.when},
                    {"what", entry.what},
                    {"why", entry.why},
                    {"undone", i >= made_edits(history)},
                    {"can_undo", entry.change.has_value()}});
  }
  return list;
}

/// Why a person confirmed the flag: the reason of the last edit that did.
std::string why_lifted(const labels::EditHistory& history, const labels::LabelFlag& flag) {
  for (std::size_t i = made_edits(history); i-- > 0;) {
    const labels::HistoryEntry& entry = history.entries[i];
    if (!entry.change) continue;
    const auto& added = entry.change->flags.added;
    if (std::any_of(added.begin(), added.end(), [&](const labels::LabelFlag& one) {
          return one.confirmed && one.reason == flag.reason && one.interval_index == flag.interval_index;
        }))
      return entry.why;
  }
  return {};
}

}  // namespace

json flags_view(const labels::Labels& labels) {
  json list = json::array();
  for (std::size_t i = 0; i < labels.flags.size(); ++i) {
    const labels::LabelFlag& flag = labels.flags[i];
    const std::string why = flag.confirmed ? why_lifted(labels.history, flag) : "";
    list.push_back({{"index", i},
                    {"interval_id", flag.interval_index ? json(labels.intervals.at(*flag.interval_index).id) : json()},
                    {"kind", flag.key.empty() ? flag.reason : flag.key.substr(0, flag.key.find(' '))},
                    {"what", flag.reason},
                    {"confirmed", flag.confirmed},
                    {"lifted_why", why.empty() ? json() : json(why)}});
  }
  return list;
}

json clocks_view(const labels::Labels& labels) {
  constexpr double ms_per_us = 1e-3;
  json clocks = {{"robot_pieces", labels.robot_clocks.size()},
                 {"robot_interval_ms", nullptr},
                 {"robot_anchors", nullptr},
                 {"video_interval_ms", nullptr},
                 {"video_anchors", nullptr}};
  const auto add = [&](const std::string& name, const alignment::FittedClock& clock) {
    clocks[name + "_interval_ms"] = ms_per_us * static_cast<double>(clock.uncertainty().count());
    clocks[name + "_anchors"] = clock.anchors;
  };
  const auto widest = std::max_element(labels.robot_clocks.begin(), labels.robot_clocks.end(),
                                       [](const auto& a, const auto& b) { return a.uncertainty() < b.uncertainty(); });
  if (widest != labels.robot_clocks.end()) add("robot", *widest);
  if (labels.video_clock) add("video", *labels.video_clock);
  return clocks;
}

std::size_t open_flags(const labels::Labels& labels) {
  return static_cast<std::size_t>(
      std::count_if(labels.flags.begin(), labels.flags.end(), [](const labels::LabelFlag& flag) { return !flag.confirmed; }));
}

bool is_confirmed(const labels::Labels& labels) {
  return open_flags(labels) == 0 && std::all_of(labels.intervals.begin(), labels.intervals.end(),
                                                [](const labels::LabelledInterval& interval) { return interval.confirmed; });
}

json labels_view(const labels::VersionedLabels& versioned, CameraTime first) {
  const labels::Labels& labels = versioned.labels;
  json intervals = json::array();
  for (const labels::LabelledInterval& interval : labels.intervals) intervals.push_back(view_of(interval, first));
  const std::size_t made = made_edits(labels.history);
  return {{"version", versioned.version},
          {"intervals", std::move(intervals)},
          {"releases", stretches_view(labels.releases, first, false)},
          {"flags", flags_view(labels)},
          {"rejected", stretches_view(labels.rejected, first, true)},
          {"remarks", labels.remarks},
          {"history", history_view(labels.history)},
          {"can_undo", made > 0 && labels.history.entries[made - 1].change.has_value()},
          {"can_redo", labels.history.undone > 0},
          {"clocks", clocks_view(labels)}};
}

}  // namespace tactile::review
