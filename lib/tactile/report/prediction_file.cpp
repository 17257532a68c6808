#include "tactile/report/prediction_file.hpp"

#include <fmt/core.h>

#include <cmath>
#include <string>
#include <string_view>

#include "tactile/core/csv.hpp"
#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/numbers.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/results/cell.hpp"
#include "tactile/results/json_view.hpp"

namespace tactile::report {
namespace {

/// Extends the last interval of `intervals` while the touch stays the same, else begins a new one.
void add_tick(std::vector<TouchInterval>& intervals, Touch touch, CameraTime before, CameraTime t) {
  if (touch == Touch::none) return;
  if (!intervals.empty() && intervals.back().touch == touch && intervals.back().end == before)
    intervals.back().end = t;
  else
    intervals.push_back({touch, before, t});
}

std::vector<pictures::PredictedInterval> intervals_in(const results::JsonView& json, const std::filesystem::path& file) {
  std::vector<pictures::PredictedInterval> intervals;
  for (const results::JsonView& interval : json.items()) {
    const double start = interval["start_us"].number(), end = interval["end_us"].number();
    const double delay_ms = interval["delay_ms"].number();
    if (!(std::abs(start) < 9e15) || !(std::abs(end) < 9e15))
      throw Error(file.string() + ": an interval has no start_us or end_us; expected camera times");
    intervals.push_back(
        {{touch_named(interval["class"].text()), camera_time(std::llround(start)), camera_time(std::llround(end))},
         std::isfinite(delay_ms) ? fmt::format("{:g} ms", delay_ms) : interval["outcome"].text()});
  }
  return intervals;
}

}  // namespace

pictures::PredictionPicture read_prediction(const std::filesystem::path& file, double history_ms) {
  const std::string content = read_text(file, std::size_t{256} << 20);
  CsvRows csv(content);
  const auto refuse = [&](std::string_view what) {
    throw Error(fmt::format("{}: line {}: {}; expected a run over time as 'tactile eval --run' writes it", file.string(),
                            csv.line(), what));
  };
  for (const std::string_view column : {"t_us", "p_none", "p_press", "p_slip", "verdict", "label", "truth", "events"}) {
    if (!csv.column(column)) refuse(fmt::format("has no column '{}'", column));
  }
  pictures::PredictionPicture picture;
  std::vector<TouchInterval> labels, true_ones;
  while (csv.next_filled()) {
    const auto field = [&](std::string_view column) {
      const auto text = csv[column];
      if (!text) refuse("has too few columns");
      return *text;
    };
    const auto t_us = whole_number_in(field("t_us")), events = whole_number_in(field("events"));
    const auto p_press = number_in(field("p_press")), p_slip = number_in(field("p_slip"));
    if (!t_us || !p_press || !p_slip || !events) refuse("has a field that is not a number");
    pictures::PredictedTick tick{
        .t = camera_time(*t_us), .events_per_ms = static_cast<double>(*events) / history_ms, .press = *p_press, .slip = *p_slip};
    // A tick stands for the time since the tick before it.
    const CameraTime before = picture.ticks.empty() ? tick.t : picture.ticks.back().t;
    if (!picture.ticks.empty() && tick.t <= before) refuse("is not later than the line before");
    const std::string_view verdict = field("verdict"), label = field("label"), truth = field("truth");
    try {
      tick.verdict = touch_named(verdict);
      picture.has_labels = picture.has_labels || !label.empty();
      picture.has_truth = picture.has_truth || !truth.empty();
      if (!label.empty()) add_tick(labels, touch_named(label), before, tick.t);
      if (truth == "unlabelled")
        add_tick(picture.unlabelled, Touch::press, before, tick.t);
      else if (!truth.empty())
        add_tick(true_ones, touch_named(truth), before, tick.t);
    } catch (const Error&) {
      refuse("has an unknown class");
    }
    picture.ticks.push_back(tick);
  }
  if (picture.ticks.empty()) refuse("has no tick");
  for (const TouchInterval& interval : labels) picture.labels.push_back({interval, {}});
  for (const TouchInterval& interval : true_ones) picture.truth.push_back({interval, {}});
  return picture;
}

void add_outcome(pictures::PredictionPicture& picture, const std::filesystem::path& file) {
  const nlohmann::json document = read_json(file);
  const results::JsonView outcome(document, file.string());
  // Older outcomes have no first event: the axis then begins with the first tick.
  if (const auto first_us = outcome["first_event_us"].number_if_there(); first_us && std::abs(*first_us) < 9e15)
    picture.first_event = camera_time(std::llround(*first_us));
  if (auto labels = intervals_in(outcome["intervals"], file); !labels.empty()) picture.labels = std::move(labels);
  if (const results::JsonView true_intervals = outcome["true_intervals"]) {
    picture.has_truth = true;
    picture.truth = intervals_in(true_intervals, file);
  }
  std::string settings = fmt::format("A tick every {:g} ms", outcome["tick_ms"].number());
  if (const std::string confirm = outcome["confirm"].text(); !confirm.empty() && confirm != "1/1")
    settings += fmt::format("; confirmed {}", confirm);
  if (outcome["thresholds"]) settings += "; decided by the thresholds " + outcome["thresholds"].text();
  picture.remarks.push_back(settings + ".");
  if (const results::JsonView whole = outcome["whole_run"]) picture.remarks.push_back(words_of(whole.get<results::Cell>()));
}

}  // namespace tactile::report
