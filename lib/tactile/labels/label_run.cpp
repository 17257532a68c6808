#include "tactile/labels/label_run.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "tactile/alignment/film_clock.hpp"
#include "tactile/alignment/film_motions.hpp"
#include "tactile/core/duration_units.hpp"
#include "tactile/labels/posterior/motion_course.hpp"
#include "tactile/labels/stage_commands.hpp"
#include "tactile/labels/visible_onset.hpp"

namespace tactile::labels {
namespace {

constexpr microseconds at_the_beginning = 20ms;
constexpr microseconds longest_disagreement = 100ms;  // of two witnesses of one onset

/// The same time within [first, last].
alignment::UncertainTime within(const alignment::UncertainTime& t, CameraTime first, CameraTime last) {
  const CameraTime at = std::clamp(t.at, first, last);
  return {at, std::min(t.low, at), std::max(t.high, at)};
}

LabelledInterval interval_of(const LikelyTouch& touch, CameraTime recorded_from, CameraTime last) {
  const alignment::UncertainTime start = within(touch.start, recorded_from, std::max(recorded_from, before(last, 1us)));
  return {.id = {},
          .touch = touch.touch,
          .start = start,
          .end = within(touch.end, after(start.at, 1us), std::max(last, after(start.at, 1us))),
          .source = "events",
          .evidence = {.events = touch.start.at, .robot = {}, .video = {}, .imu = {}},
          .confirmed = false,
          .probability = touch.probability};
}

/// Its key has no probability, which changes with each run of a session.
Doubt doubt_of(std::string_view kind, const LikelyTouch& touch, CameraTime recorded_from, std::string words) {
  return {.key = fmt::format("{} {} {:.1f}", kind, name_of(touch.touch), in_s(between(recorded_from, touch.start.at))),
          .words = std::move(words)};
}

alignment::FittedClock clock_of(const LikelyOffset& offset, std::int64_t first_stamp_us, std::size_t runs = 1) {
  alignment::FittedClock clock;
  clock.relation = {.offset_us = offset.median_us, .drift_ppm = 0, .reference_us = first_stamp_us};
  clock.offset_low_us = offset.low_us;
  clock.offset_high_us = offset.high_us;
  clock.anchors = static_cast<int>(runs);
  clock.method = runs > 1 ? fmt::format("the model of {} runs of a session", runs) : "the model of the run";
  if (offset.imu_us) clock.method += ", with the IMU";
  return clock;
}

/// The source of the arm's motions.
nlohmann::json robot_log_json(const alignment::RunSignals& signals) {
  if (!signals.has_robot) return nullptr;
  return {{"speeds_from", name_of(signals.speed_from)},
          {"arm_model", signals.arm ? nlohmann::json(name_of(*signals.arm)) : nlohmann::json(nullptr)}};
}

/// Makes the labels of a run from what is likely.
class Labeller {
 public:
  Labeller(const alignment::RunSignals& signals, const RunPosterior& posterior, const LabelOptions& options)
      : signals_(signals), posterior_(posterior), options_(options), clocks_(signals.robot.size()) {}

  Labels labels() {
    for (const Doubt& problem : signals_.problems) labels_.flags.push_back(flag_of(problem));
    labels_.remarks = signals_.remarks;
    relate_robot();
    if (signals_.video) relate_film();
    for (const LikelyTouch& touch : posterior_.touches) {
      if (is_likeliest(touch, posterior_.touches)) {
        flag(touch);
        labels_.intervals.push_back(interval_of(touch, signals_.rate.begin, signals_.rate.last));
        testify(labels_.intervals.back());
        labels_.intervals.back().visible = visible_onset(signals_.rate, signals_.quiet, touch.start, touch.end.at);
      } else if (touch.probability > 1 - options_.doubt.least_probability && !is_of_labelled(touch)) {
        labels_.flags.push_back(
            flag_of(doubt_of("touch-unsure", touch, signals_.rate.begin,
                             fmt::format("there is a {} at {:.3f} s with a probability of {:.0f} %", name_of(touch.touch),
                                         in_s(between(signals_.rate.begin, touch.start.at)), 100 * touch.probability))));
      }
    }
    labels_.releases = posterior_.releases;
    remark_what_is_missing();
    std::ranges::move(commands_without_press(signals_, clocks_, labels_), std::back_inserter(labels_.flags));
    cut_overlaps(labels_.intervals);
    name_intervals(labels_.intervals);
    return std::move(labels_);
  }

 private:
  void relate_robot() {
    for (std::size_t i = 0; i < signals_.robot.size(); ++i) {
      const RobotTime first = signals_.robot[i].states.front().t, last = signals_.robot[i].states.back().t;
      const auto found = std::find_if(posterior_.robot.begin(), posterior_.robot.end(),
                                      [i](const LikelyOffset& offset) { return offset.piece == i; });
      if (found == posterior_.robot.end()) continue;
      alignment::FittedClock clock = clock_of(*found, us_of(first), posterior_.runs_of_robot);
      if (signals_.robot.size() > 1) {
        clock.from = clock.relation.camera_from(first);
        clock.to = clock.relation.camera_from(last);
      }
      clocks_[i] = clock;
      labels_.robot_clocks.push_back(std::move(clock));
    }
    if (!signals_.has_robot) labels_.remarks.emplace_back("no robot log");
    if (!signals_.robot.empty() && labels_.robot_clocks.empty())
      labels_.remarks.emplace_back("the robot's clock is not related: the arm does not move in its log");
  }

  /// By the arm, as far as the robot's clock is known; without a log as it was inferred.
  void relate_film() {
    // A film without its end may show one motion where another is expected.
    if (10 * signals_.video->rows_without_frame > signals_.video->frames)
      return labels_.remarks.emplace_back("the film's clock is not related: the film lacks frames"), void();
    if (posterior_.film) {
      labels_.video_clock = clock_of(*posterior_.film, us_of(signals_.video->begin()));
      if (std::string remark = alignment::allow_for_drift(*labels_.video_clock, *signals_.video); !remark.empty())
        labels_.remarks.push_back(std::move(remark));
    } else if (auto found = film_clock_by_arm()) {
      if (!found->contradiction.empty()) return labels_.flags.push_back(flag_of(found->contradiction));
      if (!found->clock) return labels_.remarks.push_back("the film's clock is not related: " + found->refused);
      labels_.video_clock = std::move(found->clock);
      if (!found->remark.empty()) labels_.remarks.push_back(std::move(found->remark));
    } else {
      return labels_.remarks.emplace_back("the film's clock is not related: nothing moves in it"), void();
    }
    filmed_ = alignment::video_motions(*signals_.video, *labels_.video_clock);
  }

  /// By the first piece of the log that gives it, else why the first one does not; nothing without a piece whose clock is known.
  std::optional<alignment::FilmClock> film_clock_by_arm() const {
    std::optional<alignment::FilmClock> first;
    for (std::size_t i = 0; i < signals_.robot.size(); ++i) {
      const std::optional<alignment::ArmMotion> arm = alignment::arm_motion(signals_.robot[i]);
      if (!arm || !clocks_[i]) continue;
      const MotionCourse course(*arm, signals_.robot.size() == 1);
      alignment::FilmClock found = alignment::film_clock(
          *signals_.video, {.begin = clocks_[i]->relation.camera_from(course.begin()),
                            .step = course.step(),
                            .speed = course.speed(),
                            .sigma_us = static_cast<double>(clocks_[i]->uncertainty().count()) / alignment::normal_95});
      if (found.clock) return found;
      if (!first) first = std::move(found);
    }
    return first;
  }

  /// Whether it is another class of a touch that has a label, whose own flag says so.
  bool is_of_labelled(const LikelyTouch& touch) const {
    return std::any_of(posterior_.touches.begin(), posterior_.touches.end(), [&](const LikelyTouch& other) {
      return &other != &touch && are_alternatives(other, touch) && is_likeliest(other, posterior_.touches);
    });
  }

  /// What is doubtful of the next interval.
  void flag(const LikelyTouch& touch) {
    const std::size_t index = labels_.intervals.size();
    if (touch.probability < options_.doubt.least_probability) {
      labels_.flags.push_back(flag_of(
          doubt_of("class-unsure", touch, signals_.rate.begin,
                   fmt::format("it is a {} with a probability of {:.0f} %", name_of(touch.touch), 100 * touch.probability)),
          index));
    }
    if (touch.start.at < after(signals_.rate.begin, at_the_beginning)) {
      labels_.flags.push_back(
          flag_of(doubt("onset-unrecorded", "the recording begins within it: its onset lies before the first event"), index));
    } else if (const double ms = in_ms(between(touch.start.low, touch.start.high)); ms > options_.doubt.widest_onset_ms) {
      labels_.flags.push_back(flag_of(
          doubt_of("onset-wide", touch, signals_.rate.begin, fmt::format("its onset is known within {:.0f} ms", ms)), index));
    }
  }

  /// What the other witnesses say of the onset.
  void testify(LabelledInterval& interval) const {
    const bool is_press = interval.touch == Touch::press;
    if (is_press) {
      interval.evidence.robot = stage_command(signals_, clocks_, interval.start.at);
    } else if (const LikelyMove* lift = lift_of(interval)) {
      const LikelyOffset& clock = posterior_.robot[lift->clock];
      interval.evidence.robot = lift->span.begin;
      if (clock.imu_us) interval.evidence.imu = after(lift->span.begin, microseconds{*clock.imu_us - clock.median_us});
    }
    const auto filmed = is_press ? alignment::video_start_around(filmed_, interval.start)
                                 : alignment::video_start_near(filmed_, interval.start, longest_disagreement);
    if (filmed) interval.evidence.video = filmed->at;
  }

  /// Null if the arm does not move then.
  const LikelyMove* lift_of(const LabelledInterval& slip) const {
    const auto lift = std::find_if(posterior_.arm_moves.begin(), posterior_.arm_moves.end(), [&](const LikelyMove& move) {
      return move.span.begin <= after(slip.start.high, longest_disagreement) && move.span.end >= slip.start.low;
    });
    return lift == posterior_.arm_moves.end() ? nullptr : &*lift;
  }

  void remark_what_is_missing() {
    for (const Touch touch : {Touch::press, Touch::slip}) {
      const bool has_one = std::any_of(labels_.intervals.begin(), labels_.intervals.end(),
                                       [touch](const LabelledInterval& interval) { return interval.touch == touch; });
      if (!has_one) labels_.remarks.push_back(fmt::format("no {} found", name_of(touch)));
    }
  }

  const alignment::RunSignals& signals_;
  const RunPosterior& posterior_;
  const LabelOptions& options_;
  RobotPieceClocks clocks_;
  std::vector<alignment::VideoMotion> filmed_;
  Labels labels_;
};

}  // namespace

Labels label_signals(const alignment::RunSignals& signals, const RunPosterior& posterior, const LabelOptions& options) {
  Labels labels = Labeller(signals, posterior, options).labels();
  labels.provenance = {{"made_by", "tactile label"},
                       {"settings", settings_of(options)},
                       {"robot_log", robot_log_json(signals)},
                       {"first_event_us", us_of(signals.rate.begin)},
                       {"hot_pixels", signals.rate.hot_pixels},
                       {"quiet_events_per_s", signals.quiet.mean * 1e6 / static_cast<double>(signals.rate.bin.count())}};
  return labels;
}

Labels label_run(const RunFolder& run, const LabelOptions& options) {
  const alignment::RunSignals signals = alignment::read_run_signals(run, options.signals);
  Labels labels = label_signals(signals, run_posterior(signals), options);
  labels.provenance["inputs"] = alignment::hashes_of_inputs(run);
  return labels;
}

}  // namespace tactile::labels
