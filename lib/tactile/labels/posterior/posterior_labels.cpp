#include "tactile/labels/posterior/posterior_labels.hpp"

#include <algorithm>

#include "tactile/core/duration_units.hpp"
#include "tactile/labels/posterior/run_model_numbers.hpp"
#include "tactile/labels/posterior/run_posterior.hpp"

namespace tactile::labels {
namespace {

constexpr microseconds at_the_beginning = 20ms;

/// A later touch ends the one before it.
void end_before_next(std::vector<LabelledInterval>& intervals) {
  for (std::size_t i = 0; i + 1 < intervals.size(); ++i) {
    alignment::UncertainTime& end = intervals[i].end;
    const CameraTime next = intervals[i + 1].start.at;
    end = {std::min(end.at, next), std::min(end.low, next), std::min(end.high, next)};
  }
}

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

alignment::FittedClock clock_of(const LikelyOffset& offset, RobotTime first_stamp) {
  alignment::FittedClock clock;
  clock.relation = {.offset_us = offset.median_us, .drift_ppm = 0, .reference_us = us_of(first_stamp)};
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
  end_before_next(labels.intervals);
  name_intervals(labels.intervals);
  labels.releases = posterior.releases;
  if (posterior.robot) labels.robot_clocks.push_back(clock_of(*posterior.robot, posterior.robot->first_stamp));
  labels.provenance = {{"made_by", "tactile label"},
                       {"first_event_us", us_of(signals.rate.begin)},
                       {"hot_pixels", signals.rate.hot_pixels},
                       {"quiet_events_per_s", signals.quiet.mean * 1e6 / static_cast<double>(signals.rate.bin.count())}};
  return labels;
}

}  // namespace tactile::labels
