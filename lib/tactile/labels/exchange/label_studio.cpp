#include "tactile/labels/exchange/label_studio.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <pugixml.hpp>
#include <set>
#include <sstream>

#include "tactile/core/duration_units.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/text.hpp"
#include "tactile/core/whole_file.hpp"

namespace tactile::labels {
namespace {

using nlohmann::json;

constexpr const char* control_name = "touch";
constexpr const char* object_name = "signals";
constexpr const char* result_type = "timeserieslabels";
constexpr const char* time_column = "time_s";

json result_of(const LabelsToExport& labels, const LabelledInterval& interval) {
  const ClockRelation clock = labels.times.to_camera(labels.first_event);
  return {{"id", interval.id},
          {"from_name", control_name},
          {"to_name", object_name},
          {"type", result_type},
          {"value",
           {{"start", in_s(microseconds{clock.clock_us_from(interval.start.at)})},
            {"end", in_s(microseconds{clock.clock_us_from(interval.end.at)})},
            {"instant", interval.start.at == interval.end.at},
            {result_type, json::array({name_of(interval.touch)})}}}};
}

json task_of(const LabelsToExport& labels) {
  check_ids(labels);
  json result = json::array();
  std::string flags = doubts_of(labels.labels, std::nullopt);
  for (std::size_t i = 0; i < labels.labels.intervals.size(); ++i) {
    const LabelledInterval& interval = labels.labels.intervals[i];
    result.push_back(result_of(labels, interval));
    if (const std::string own = doubts_of(labels.labels, i); !own.empty())
      flags += fmt::format("{}{}: {}", flags.empty() ? "" : "; ", interval.id, own);
  }
  json signals = {{time_column, labels.signals.time_s}};
  for (const auto& [name, values] : labels.signals.curves) signals[name] = values;
  json object = {{"data",
                  {{"run", labels.run},
                   {"flags", flags.empty() ? "no flag stands" : flags},
                   {"origin", name_of(labels.times.origin)},
                   {"zero_s", in_s(microseconds{labels.times.zero_us})},
                   {"drift_ppm", labels.times.drift_ppm},
                   {object_name, std::move(signals)}}},
                 {"predictions",
                  json::array({{{"model_version", "tactile label"}, {"score", flags.empty() ? 1.0 : 0.0}, {"result", result}}})}};
  const std::vector<LabelledInterval>& intervals = labels.labels.intervals;
  if (!intervals.empty() &&
      std::all_of(intervals.begin(), intervals.end(), [](const LabelledInterval& i) { return i.confirmed; }))
    object["annotations"] = json::array({{{"was_cancelled", false}, {"result", result}}});
  return object;
}

/// Keeps only the needed parts of a file: the signals, which are most of it, are skipped while parsing.
json read_tasks(const std::filesystem::path& file) {
  static const std::set<std::string> kept{"data",        "run",           "origin", "zero_s",  "drift_ppm",
                                          "annotations", "was_cancelled", "result", "id",      "type",
                                          "value",       "start",         "end",    "instant", result_type};
  constexpr std::size_t most_values = 1'000'000;
  constexpr int deepest = 20;
  const std::string text = read_text(file);
  std::size_t values = 0;
  const auto keep = [&](int depth, json::parse_event_t event, json& value) {
    if (depth > deepest)
      throw Error(fmt::format("{}: nests values more than {} deep; expected tasks of Label Studio", file.string(), deepest));
    if (event == json::parse_event_t::key) return kept.contains(value.get_ref<const std::string&>());
    if (event == json::parse_event_t::value || event == json::parse_event_t::array_start ||
        event == json::parse_event_t::object_start)
      check_count(++values, most_values, "values", file);
    return true;
  };
  try {
    return json::parse(text, keep);
  } catch (const json::exception& e) {
    throw Error(fmt::format("{}: is not JSON ({}); expected Label Studio's export as JSON", file.string(), e.what()));
  }
}

struct ReadNumber {
  std::int64_t us, rounding_us;
};

ReadNumber us_in(const json& value, const char* key, const std::string& where) {
  const auto found = value.find(key);
  if (found == value.end() || !found->is_number()) {
    throw Error(fmt::format("{}: '{}' is not a number; expected seconds; timeFormat must not be set", where, key));
  }
  const double seconds = found->get<double>();
  if (!(std::abs(seconds) < 9.2e12)) throw Error(fmt::format("{}: '{}' is {}; expected seconds", where, key, seconds));
  const double step = std::nextafter(std::abs(seconds), std::numeric_limits<double>::infinity()) - std::abs(seconds);
  return {std::llround(seconds * 1e6), std::max<std::int64_t>(1, std::llround(std::ceil(step * 1e6)))};
}

void set_times(ImportedLabels& labels, const json& data, const std::string& where) {
  if (!data.contains("origin")) return;
  const auto name = member<std::string>(data, "origin", where);
  const std::optional<TimeOrigin> origin = time_origin_named(name);
  if (!origin) throw Error(fmt::format("{}: 'origin' is {}; expected first-event, camera or video", where, shown_text(name)));
  FileTimes times{.origin = *origin};
  if (data.contains("zero_s")) times.zero_us = us_in(data, "zero_s", where).us;
  if (data.contains("drift_ppm")) times.drift_ppm = member<double>(data, "drift_ppm", where);
  if (!(std::abs(times.drift_ppm) < 1e5))
    throw Error(fmt::format("{}: 'drift_ppm' is {}; expected -100000 to 100000", where, times.drift_ppm));
  labels.origin = origin;
  if (*origin != TimeOrigin::video || data.contains("zero_s")) labels.times = times;
}

ImportedInterval imported_interval_in(const json& result, const std::string& where) {
  ImportedInterval interval;
  if (const auto id = result.find("id"); id != result.end() && id->is_string()) {
    interval.id = id->get<std::string>();
    interval.id.resize(std::min(interval.id.find('#'), interval.id.size()));  // after it Label Studio appends the annotation
  }
  interval.where = fmt::format("{}, result {}", where, shown_text(interval.id));
  const auto value = member<json>(result, "value", interval.where);
  if (!value.is_object()) throw Error(interval.where + ": 'value' is not an object; expected start, end and timeserieslabels");
  const ReadNumber start = us_in(value, "start", interval.where), end = us_in(value, "end", interval.where);
  interval.start_us = start.us;
  interval.start_rounding_us = start.rounding_us;
  interval.end_us = end.us;
  interval.end_rounding_us = end.rounding_us;
  const auto names = member<json>(value, result_type, interval.where);
  if (!names.is_array() || names.size() != 1 || !names[0].is_string())
    throw Error(fmt::format("{}: '{}' must have one class; expected [\"press\"] or [\"slip\"]", interval.where, result_type));
  const auto name = names[0].get<std::string>();
  if (name != name_of(Touch::press) && name != name_of(Touch::slip))
    throw Error(fmt::format("{}: {} is not a class; expected press or slip", interval.where, shown_text(name)));
  interval.touch = touch_named(name);
  interval.confirmed = true;
  return interval;
}

ImportedLabels task_in(const json& task, const std::filesystem::path& file, std::size_t number) {
  const std::string nameless = fmt::format("{}, task {}", file.string(), number);
  if (!task.is_object() || !task.contains("data") || !task["data"].is_object())
    throw Error(nameless + ": is not a task; expected Label Studio's export as JSON, not as JSON-MIN or CSV");
  const json& data = task["data"];
  ImportedLabels labels{.where = file.string(), .looked_at = false};
  if (data.contains("run")) labels.run = member<std::string>(data, "run", nameless);
  const std::string where = labels.run ? fmt::format("{}, {}", nameless, shown_text(*labels.run)) : nameless;
  set_times(labels, data, where);
  const auto annotations = task.find("annotations");
  if (annotations == task.end()) return labels;
  if (!annotations->is_array()) throw Error(where + ": 'annotations' is not a list; expected Label Studio's export as JSON");
  const json* chosen = nullptr;
  for (const json& annotation : *annotations) {
    if (!annotation.is_object()) throw Error(where + ": an annotation is not an object; expected Label Studio's export as JSON");
    const auto cancelled = annotation.find("was_cancelled");
    if (cancelled != annotation.end() && cancelled->is_boolean() && cancelled->get<bool>()) continue;
    if (chosen != nullptr) throw Error(where + ": has several annotations; expected one, delete the others");
    chosen = &annotation;
  }
  if (chosen == nullptr) return labels;
  labels.looked_at = true;
  const auto results = member<json>(*chosen, "result", where);
  if (!results.is_array()) throw Error(where + ": 'result' is not a list; expected an annotation's results");
  for (const json& result : results) {
    if (!result.is_object()) throw Error(where + ": a result is not an object; expected an annotation's results");
    if (result.value("type", json()) != result_type) continue;
    labels.intervals.push_back(imported_interval_in(result, where));
    check_count(labels.intervals.size(), most_imported_intervals, "results", file);
  }
  return labels;
}

}  // namespace

std::string label_studio_text(std::span<const LabelsToExport> runs) {
  std::string text;
  for (const LabelsToExport& run : runs)
    text += (text.empty() ? "[" : ",\n") + task_of(run).dump(-1, ' ', false, json::error_handler_t::replace);
  return (text.empty() ? "[" : text) + "]\n";
}

std::string label_studio_config(std::span<const LabelsToExport> runs) {
  pugi::xml_document xml;
  const auto append = [](pugi::xml_node parent, const char* name,
                         std::initializer_list<std::pair<const char*, const char*>> attributes) {
    pugi::xml_node node = parent.append_child(name);
    for (const auto& [key, value] : attributes) node.append_attribute(key) = value;
    return node;
  };
  pugi::xml_node view = xml.append_child("View");
  append(view, "Header", {{"value", "$run"}});
  append(view, "Text", {{"name", "flags"}, {"value", "$flags"}});
  pugi::xml_node labels = append(view, "TimeSeriesLabels", {{"name", control_name}, {"toName", object_name}});
  append(labels, "Label", {{"value", "press"}, {"background", "#1f77b4"}});
  append(labels, "Label", {{"value", "slip"}, {"background", "#ff7f0e"}});
  pugi::xml_node series = append(view, "TimeSeries",
                                 {{"name", object_name},
                                  {"value", "$signals"},
                                  {"valueType", "json"},
                                  {"timeColumn", time_column},
                                  {"timeDisplayFormat", ".4f"},
                                  {"durationDisplayFormat", ".4f"}});
  if (!runs.empty()) {
    for (const auto& [name, values] : runs.front().signals.curves)
      append(series, "Channel", {{"column", name.c_str()}, {"legend", name.c_str()}, {"displayFormat", ".1f"}});
  }
  std::ostringstream text;
  xml.save(text, "  ", pugi::format_indent | pugi::format_no_declaration, pugi::encoding_utf8);
  return text.str();
}

std::vector<ImportedLabels> read_label_studio(const std::filesystem::path& file) {
  const json tasks = read_tasks(file);
  std::vector<ImportedLabels> runs;
  if (tasks.is_object()) {
    runs.push_back(task_in(tasks, file, 1));
    return runs;
  }
  if (!tasks.is_array() || tasks.empty())
    throw Error(file.string() + ": has no task; expected Label Studio's export as JSON, a list of tasks");
  check_count(tasks.size(), most_imported_runs, "tasks", file);
  for (std::size_t i = 0; i < tasks.size(); ++i) runs.push_back(task_in(tasks[i], file, i + 1));
  return runs;
}

}  // namespace tactile::labels
