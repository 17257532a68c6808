#include "tactile/labels/posterior/posterior_labels.hpp"

#include <algorithm>

#include "tactile/core/duration_units.hpp"
#include "tactile/labels/posterior/run_model_numbers.hpp"
#include "tactile/labels/posterior/run_posterior.hpp"

namespace tactile::labels {
namespace {

constexpr microseconds at_the_beginning = 20ms;

LabelledInterval interval_of(const LikelyTouch& touch) {
  return {.id = {},
          .touch = touch.touch,
          .start = touch.start,
          .end = touch.end,
          .source = "events",
          .evidence = {.events = touch.start.at, .robot = {}, .video = {}, .imu = {}},
          .confirmed = false,
          .probability = touch.probability};
}

std::vector<LabelFlag> flags_of(const LikelyTouch& touch, std::size_t index, CameraTime recorded_from) {
  std::vector<LabelFlag> flags;
  if (touch.probability < numbers::sure) {
    flags.push_back(
        flag_of(doubt("class-unsure", "it is a {} with a probability of {:.0f} %", name_of(touch.touch), 100 * touch.probability),
                index));
  }
  if (touch.start.at < after(recorded_from, at_the_beginning)) {
    flags.push_back(
        flag_of(doubt("onset-unrecorded", "the recording begins within it: its onset lies before the first event"), index));
  } else if (const double width_ms = in_ms(between(touch.start.low, touch.start.high)); width_ms > numbers::widest_onset_ms) {
    flags.push_back(flag_of(doubt("onset-wide", "its onset is known within {:.0f} ms", width_ms), index));
  }
  return flags;
}

LabelFlag flag_of_unlabelled(const LikelyTouch& touch, CameraTime recorded_from) {
  return flag_of(doubt("touch-unsure", "there is a {} at {:.3f} s with a probability of {:.0f} %", name_of(touch.touch),
                       1e-3 * in_ms(between(recorded_from, touch.start.at)), 100 * touch.probability));
}

alignment::FittedClock clock_of(const LikelyOffset& offset) {
  alignment::FittedClock clock;
  clock.relation = {.offset_us = offset.median_us, .drift_ppm = 0, .reference_us = us_of(offset.first_stamp)};
  clock.offset_low_us = offset.low_us;
  clock.offset_high_us = offset.high_us;
  clock.anchors = 1;
  clock.method = "the model of the run";
  return clock;
}

}  // namespace

Labels posterior_labels(const alignment::RunSignals& signals) {
  const RunPosterior posterior = run_posterior(signals);
  Labels labels;
  for (const Doubt& problem : signals.problems) labels.flags.push_back(flag_of(problem));
  labels.remarks = signals.remarks;
  for (const LikelyTouch& touch : posterior.touches) {
    if (touch.probability >= 0.5) {
      std::ranges::move(flags_of(touch, labels.intervals.size(), signals.rate.begin), std::back_inserter(labels.flags));
      labels.intervals.push_back(interval_of(touch));
    } else if (touch.probability > 1 - numbers::sure) {
      labels.flags.push_back(flag_of_unlabelled(touch, signals.rate.begin));
    }
  }
  cut_overlaps(labels.intervals);
  name_intervals(labels.intervals);
  labels.releases = posterior.releases;
  if (posterior.robot) labels.robot_clocks.push_back(clock_of(*posterior.robot));
  return labels;
}

}  // namespace tactile::labels
