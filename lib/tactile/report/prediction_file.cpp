#include "tactile/report/prediction_file.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/results/json_view.hpp"

namespace tactile {
namespace {

constexpr std::array<std::string_view, 8> columns{"t_us", "p_press", "p_slip", "verdict", "label", "truth", "events", "p_none"};
enum Column : std::size_t { time, press, slip, verdict, label, truth, events };

std::vector<std::string_view> fields_of(std::string_view line) {
  std::vector<std::string_view> fields;
  for (std::size_t begin = 0;;) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    fields.push_back(line.substr(begin, end - begin));
    if (end == line.size()) return fields;
    begin = end + 1;
  }
}

/// Grows the last interval of `intervals` while the same touch goes on, else begins one.
void add_tick(std::vector<TouchInterval>& intervals, Touch touch, CameraTime before, CameraTime t) {
  if (!intervals.empty() && intervals.back().touch == touch && intervals.back().end == before)
    intervals.back().end = t;
  else
    intervals.push_back({touch, before, t});
}

}  // namespace

PredictionPicture read_prediction(const std::filesystem::path& file, double history_ms) {
  const std::string text = read_text(file);
  PredictionPicture picture;
  std::array<std::size_t, columns.size()> place{};
  std::vector<TouchInterval> labels;
  std::size_t line_number = 0;
  const auto refuse = [&](std::string_view what) {
    throw Error(fmt::format("{}: line {}: {}; expected a run over time as 'tactile eval --run' writes it", file.string(),
                            line_number, what));
  };
  std::vector<double> history_events;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    std::string_view line(text.data() + begin, end - begin);
    begin = end + 1;
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    ++line_number;
    const std::vector<std::string_view> fields = fields_of(line);
    if (line_number == 1) {
      for (std::size_t i = 0; i < columns.size(); ++i) {
        const auto found = std::find(fields.begin(), fields.end(), columns[i]);
        if (found == fields.end()) refuse(fmt::format("has no column '{}'", columns[i]));
        place[i] = static_cast<std::size_t>(found - fields.begin());
      }
      continue;
    }
    if (line.empty()) continue;
    if (fields.size() <= *std::max_element(place.begin(), place.end())) refuse("has too few columns");
    const auto t_us = whole_number_in(fields[place[time]]);
    const auto p_press = number_in(fields[place[press]]), p_slip = number_in(fields[place[slip]]);
    const auto in_history = whole_number_in(fields[place[events]]);
    if (!t_us || !p_press || !p_slip || !in_history) refuse("holds what is no number");
    PredictedTick tick{.t = camera_time(*t_us),
                       .events_per_ms = static_cast<double>(*in_history) / history_ms,
                       .press = *p_press,
                       .slip = *p_slip};
    if (!picture.ticks.empty() && tick.t <= picture.ticks.back().t) refuse("lies not behind the one before");
    const std::string_view said = fields[place[verdict]], labelled = fields[place[label]], real = fields[place[truth]];
    try {
      tick.verdict = touch_named(said);
      // A tick stands for the time since the one before it.
      const CameraTime before = picture.ticks.empty() ? tick.t : picture.ticks.back().t;
      if (!labelled.empty()) {
        picture.has_labels = true;
        if (const Touch touch = touch_named(labelled); touch != Touch::none) add_tick(labels, touch, before, tick.t);
      }
      if (!real.empty()) {
        picture.has_truth = true;
        if (real == "unlabelled")
          add_tick(picture.unlabelled, Touch::press, before, tick.t);
        else if (const Touch touch = touch_named(real); touch != Touch::none)
          add_tick(picture.truth, touch, before, tick.t);
      }
    } catch (const Error&) {
      refuse("holds another class than there can be");
    }
    picture.ticks.push_back(tick);
  }
  if (picture.ticks.empty()) refuse("holds no tick");
  for (const TouchInterval& interval : labels) picture.labels.push_back({interval, {}});
  return picture;
}

void add_outcome(PredictionPicture& picture, const std::filesystem::path& file) {
  const nlohmann::json document = read_json(file);
  const JsonView outcome(document, file.string());
  std::vector<PredictedInterval> labels;
  for (const JsonView& interval : outcome["intervals"].items()) {
    const double start = interval["start_us"].number(), end = interval["end_us"].number();
    const double delay_ms = interval["delay_ms"].number();
    if (!(std::abs(start) < 9e15) || !(std::abs(end) < 9e15))
      throw Error(file.string() + ": an interval without start_us and end_us; expected times of the camera");
    labels.push_back({{touch_named(interval["class"].text()), camera_time(std::llround(start)), camera_time(std::llround(end))},
                      std::isfinite(delay_ms) ? fmt::format("{:g} ms", delay_ms) : interval["outcome"].text()});
  }
  if (!labels.empty()) picture.labels = std::move(labels);
  std::string settings = fmt::format("A tick every {:g} ms", outcome["tick_ms"].number());
  if (const std::string confirm = outcome["confirm"].text(); !confirm.empty() && confirm != "1/1")
    settings += fmt::format("; confirmed {}", confirm);
  picture.remarks.push_back(settings + ".");
  if (const JsonView alarms = outcome["false_alarms"]) {
    picture.remarks.push_back(fmt::format(
        "Over each labelled interval: the detection delay. False alarms: {}; begun just after an interval: {}, in motion that "
        "nobody labels: {}.",
        alarms["count"].count(), alarms["after_intervals"].count(), alarms["unlabelled"].count()));
  }
}

}  // namespace tactile
