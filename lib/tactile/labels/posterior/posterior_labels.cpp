#include "tactile/labels/posterior/posterior_labels.hpp"

#include <algorithm>

#include "tactile/alignment/film_motions.hpp"
#include "tactile/core/duration_units.hpp"
#include "tactile/labels/film_clock.hpp"
#include "tactile/labels/stage_presses.hpp"

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

std::vector<LabelFlag> flags_of(const LikelyTouch& touch, std::size_t index, CameraTime recorded_from,
                                const DoubtLimits& limits) {
  std::vector<LabelFlag> flags;
  if (touch.probability < limits.least_probability) {
    flags.push_back(
        flag_of(doubt("class-unsure", "it is a {} with a probability of {:.0f} %", name_of(touch.touch), 100 * touch.probability),
                index));
  }
  if (touch.start.at < after(recorded_from, at_the_beginning)) {
    flags.push_back(
        flag_of(doubt("onset-unrecorded", "the recording begins within it: its onset lies before the first event"), index));
  } else if (const double width_ms = in_ms(between(touch.start.low, touch.start.high)); width_ms > limits.widest_onset_ms) {
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
  clock.relation = {.offset_us = offset.median_us, .drift_ppm = 0, .reference_us = offset.first_stamp_us};
  clock.offset_low_us = offset.low_us;
  clock.offset_high_us = offset.high_us;
  clock.anchors = 1;
  clock.method = "the model of the run";
  return clock;
}

/// What the other witnesses say of the touches that the model has found.
class Witnesses {
 public:
  Witnesses(const alignment::RunSignals& signals, const RunPosterior& posterior, Labels& labels)
      : signals_(signals), posterior_(posterior), labels_(labels) {
    clocks_.pieces.resize(signals.robot.size());
    clocks_.anchors.resize(signals.robot.size());
    if (!posterior.robot) return;
    labels.robot_clocks.push_back(clock_of(*posterior.robot));
    for (std::size_t i = 0; i < signals.robot.size(); ++i) {
      if (us_of(signals.robot[i].log.states.front().t) == posterior.robot->first_stamp_us)
        clocks_.pieces[i] = labels.robot_clocks.front();
    }
  }

  void relate_film(const alignment::VideoClockOptions& options) {
    if (!signals_.video) return;
    if (posterior_.film) {
      labels_.video_clock = clock_of(*posterior_.film);
      motions_ = alignment::video_motions(*signals_.video, *labels_.video_clock);
      return;
    }
    alignment::VideoClockFit fit = fit_film_clock(signals_, clocks_, options);
    if (!fit.contradiction.empty()) {
      labels_.flags.push_back(flag_of(fit.contradiction));
    } else if (!fit.clock) {
      labels_.remarks.push_back("the film's clock is not related: " + fit.refused);
    } else {
      labels_.video_clock = std::move(fit.clock);
      if (!fit.remark.empty()) labels_.remarks.push_back(std::move(fit.remark));
      motions_ = alignment::video_motions(*signals_.video, *labels_.video_clock);
    }
  }

  void testify(LabelledInterval& interval) const {
    const bool is_press = interval.touch == Touch::press;
    interval.evidence.robot = is_press ? stage_command(signals_, clocks_, interval.start.at) : start_of_lift(interval);
    const auto filmed = is_press ? alignment::video_start_around(motions_, interval.start)
                                 : alignment::video_start_near(motions_, interval.start, longest_disagreement);
    if (filmed) interval.evidence.video = filmed->at;
  }

 private:
  static constexpr microseconds longest_disagreement = 100ms;

  std::optional<CameraTime> start_of_lift(const LabelledInterval& slip) const {
    for (const alignment::CameraSpan& move : posterior_.arm_moves) {
      if (move.begin <= after(slip.start.high, longest_disagreement) && move.end >= slip.start.low) return move.begin;
    }
    return std::nullopt;
  }

  const alignment::RunSignals& signals_;
  const RunPosterior& posterior_;
  Labels& labels_;
  alignment::RobotClocks clocks_;
  std::vector<alignment::VideoMotion> motions_;
};

}  // namespace

Labels posterior_labels(const alignment::RunSignals& signals, const RunPosterior& posterior, const DoubtLimits& limits,
                        const alignment::VideoClockOptions& film) {
  Labels labels;
  for (const Doubt& problem : signals.problems) labels.flags.push_back(flag_of(problem));
  labels.remarks = signals.remarks;
  Witnesses witnesses(signals, posterior, labels);
  witnesses.relate_film(film);
  for (const LikelyTouch& touch : posterior.touches) {
    if (touch.probability >= 0.5) {
      std::ranges::move(flags_of(touch, labels.intervals.size(), signals.rate.begin, limits), std::back_inserter(labels.flags));
      witnesses.testify(labels.intervals.emplace_back(interval_of(touch)));
    } else if (touch.probability > 1 - limits.least_probability) {
      labels.flags.push_back(flag_of_unlabelled(touch, signals.rate.begin));
    }
  }
  cut_overlaps(labels.intervals);
  name_intervals(labels.intervals);
  labels.releases = posterior.releases;
  return labels;
}

}  // namespace tactile::labels
