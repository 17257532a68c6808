#include "tactile/labels/label_run.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "tactile/alignment/film_motions.hpp"
#include "tactile/core/duration_units.hpp"
#include "tactile/labels/arm_moves.hpp"
#include "tactile/labels/film_clock.hpp"
#include "tactile/labels/posterior/posterior_labels.hpp"
#include "tactile/labels/run_bursts.hpp"
#include "tactile/labels/stage_presses.hpp"
#include "tactile/labels/unlabelled_bursts.hpp"
#include "tactile/labels/unlikely_presses.hpp"
#include "tactile/labels/unlogged_lift.hpp"

namespace tactile::labels {
namespace {

constexpr microseconds start_and_stop = 500ms;  // the recorders of one run may begin and end so far apart
constexpr microseconds least_rest = 20ms;       // of a skin that is seen at rest before a touch
constexpr microseconds frame_of_film = 50ms;    // a motion may show in the film a frame before it

const ArmMove* lift_of(const ArmMoves& moves, const LabelledInterval& slip) {
  const auto nearest = std::min_element(moves.lifts.begin(), moves.lifts.end(), [&](const ArmMove& a, const ArmMove& b) {
    return std::chrono::abs(between(a.start, slip.start.at)) < std::chrono::abs(between(b.start, slip.start.at));
  });
  return nearest == moves.lifts.end() ? nullptr : &*nearest;
}

/// The source of the arm's motions.
nlohmann::json robot_log_json(const alignment::RunSignals& signals) {
  if (!signals.has_robot) return nullptr;
  return {{"speeds_from", name_of(signals.speed_from)},
          {"arm_model", signals.arm ? nlohmann::json(name_of(*signals.arm)) : nlohmann::json(nullptr)}};
}

/// Makes the labels of a run, step by step.
class Labeller {
 public:
  Labeller(const alignment::RunSignals& signals, const alignment::RobotClocks& clocks, const LabelOptions& options)
      : signals_(signals), clocks_(clocks), options_(options), moves_(arm_moves(signals, clocks)) {}

  Labels labels() {
    for (const Doubt& problem : signals_.problems) flag(problem);
    labels_.remarks = signals_.remarks;
    // A doubt does not matter where another anchor gives the clock, or where there is nothing to place.
    for (const Doubt& one : clocks_.doubts) a_clock_is_refused() ? flag(one) : labels_.remarks.push_back(one.words);
    for (const Doubt& one : clocks_.contradictions) flag(one);
    if (signals_.has_robot && !lifts_are_known() && !moves_.rises) {
      flag(doubt("robot-log-no-lift",
                 "the robot log has no lift, but only {:.2f} s of the recording's {:.2f} s: press and slip are distinguished by "
                 "their order alone",
                 1e-3 * in_ms(moves_.logged), 1e-3 * in_ms(recorded())));
    }

    relate_clocks();
    find_intervals();
    for (std::size_t i = 0; i < labels_.intervals.size(); ++i) witness(i);
    look_for_what_is_missing();
    cut_overlaps(labels_.intervals);
    std::ranges::move(unlikely_presses(labels_), std::back_inserter(labels_.flags));
    std::ranges::move(missing_presses(signals_, clocks_, labels_), std::back_inserter(labels_.flags));
    name_intervals(labels_.intervals);
    return std::move(labels_);
  }

 private:
  void flag(Doubt reason, std::optional<std::size_t> interval = std::nullopt) {
    labels_.flags.push_back(flag_of(std::move(reason), interval));
  }

  /// Whether a piece of the log with motion or commands has no clock.
  bool a_clock_is_refused() const {
    for (std::size_t i = 0; i < signals_.robot.size(); ++i) {
      const alignment::RobotPiece& piece = signals_.robot[i];
      if (!clocks_.pieces[i] && !(piece.phases.empty() && piece.log.output_changes.empty())) return true;
    }
    return false;
  }

  microseconds recorded() const { return between(signals_.rate.begin, signals_.rate.last); }
  /// Whether the log has every lift: a log that is shorter than the recording may lack one.
  bool lifts_are_known() const { return moves_.all_placed && (moves_.rises || moves_.logged + start_and_stop >= recorded()); }

  std::optional<UnloggedLift> lift_without_log(const std::vector<alignment::Burst>& bursts,
                                               const std::vector<LitRate>& lit) const {
    if (signals_.has_robot) return std::nullopt;
    std::vector<bool> may_slip;
    for (std::size_t i = 0; i < bursts.size(); ++i) {
      const bool releases = i == 0 || lit[i].undoes > options_.touches.releases;
      may_slip.push_back(!releases && !alignment::is_after_effect(bursts[i], signals_.rate, bursts));
    }
    return unlogged_lift(signals_.imu, video_motions_, signals_.rate, bursts, may_slip);
  }

  void find_intervals() {
    events::RecordingReader recording(signals_.run.events());
    const std::vector<alignment::Burst> bursts = bursts_of_run(recording, signals_, moves_.lifts, options_.signals.activity);
    const std::vector<LitRate> lit = lit_rates(recording, signals_.event_stream, signals_.rate, bursts);
    std::vector<double> undoes(lit.size());
    std::transform(lit.begin(), lit.end(), undoes.begin(), [](const LitRate& burst) { return burst.undoes; });
    const std::optional<UnloggedLift> unlogged = lift_without_log(bursts, lit);
    std::optional<std::vector<ArmMove>> slips_in;
    if (lifts_are_known()) slips_in = moves_.lifts;
    if (unlogged) slips_in = std::vector{unlogged->move};
    const std::vector<BurstKind> kinds = kinds_of(signals_.rate, bursts, slips_in, moves_.taps, undoes, options_.touches);
    if (!signals_.has_robot) flag(no_robot_log(unlogged));
    const UnlabelledBursts unlabelled = unlabelled_bursts(signals_, clocks_, moves_, bursts, kinds, options_.touches);
    for (const Doubt& one : unlabelled.doubts) flag(one);
    if (!unlabelled.remark.empty()) labels_.remarks.push_back(unlabelled.remark);
    for (std::size_t i = 0; i < bursts.size(); ++i) {
      if (kinds[i] == BurstKind::release) {
        labels_.releases.push_back({Touch::none, signals_.rate.begin_of(bursts[i].begin), signals_.rate.begin_of(bursts[i].end)});
      } else if (kinds[i] == BurstKind::press) {
        const auto rests_from = i > 0 ? std::optional(signals_.rate.begin_of(bursts[i - 1].end)) : std::nullopt;
        const FoundTime onset = press_onset(lit[i], options_.onset, rests_from);
        add(Touch::press, onset, press_end(lit[i], onset.time, options_.end));
      } else if (kinds[i] == BurstKind::slip) {
        FoundTime onset = slip_onset(lit[i], options_.onset, earliest_slip(bursts[i]), moves_.rings);
        if (is_confirmed_by_lift(onset.time, bursts[i])) onset.doubt = {};
        const std::optional<alignment::UncertainTime> stop = arm_stop(bursts[i]);
        const FoundTime end = slip_end(lit[i], onset.time, options_.end, stop);
        if (!flag_if_firm(bursts[i], end.time)) add(Touch::slip, onset, end, stop.has_value());
      }
    }
  }

  /// Whether the object came along with the arm: the skin moves no further than it can shear, and the arm continues for long. A
  /// person must decide whether the object then slid over a face that is too smooth to see.
  bool flag_if_firm(const alignment::Burst& burst, const alignment::UncertainTime& seen_until) {
    constexpr double longest_shear_m = 2.5e-3, least_rest_m = 5e-3;
    const ArmMove* lift = lift_around(moves_.lifts, signals_.rate, burst);
    if (lift == nullptr || lift->uncertainty > well_placed || after(seen_until.at, options_.end.longest_unseen) > lift->end)
      return false;
    const std::optional<double> sheared = travel_until(*lift, seen_until.at), whole = travel_until(*lift, lift->end);
    if (!sheared || *sheared > longest_shear_m || *whole < *sheared + least_rest_m) return false;
    ++firm_lifts_;
    flag(doubt("lift-firm",
               "the skin moves over the first {:.1f} mm of the lift only, of {:.0f} mm: the object came along, or slid without "
               "a trace",
               1e3 * *sheared, 1e3 * *whole));
    return true;
  }

  /// An onset or end in a gap is found at the gap's edge: it may lie anywhere within.
  void allow_for_gaps(alignment::UncertainTime& t, const std::string& what) {
    constexpr microseconds near = 20ms;
    for (const alignment::CameraSpan& gap : signals_.gaps) {
      if (gap.begin > after(t.high, near) || gap.end < before(t.low, near)) continue;
      t.low = std::min(t.low, gap.begin);
      t.high = std::max(t.high, gap.end);
      flag(
          doubt(what + "-in-gap", "its {} may lie in the recording's gap of {:.0f} ms", what, in_ms(between(gap.begin, gap.end))),
          labels_.intervals.size());
    }
  }

  /// @param ends_with_arm  the arm's stop is known: a slip that is no longer seen ends by then
  void add(Touch touch, FoundTime start, FoundTime end, bool ends_with_arm = false) {
    if (start.time.at < after(signals_.rate.begin, least_rest))
      start.doubt = doubt("onset-unrecorded", "the recording begins within it: its onset lies before the first event");
    if (!labels_.intervals.empty() && start.time.at <= labels_.intervals.back().start.at) {
      const CameraTime first = after(labels_.intervals.back().start.at, signals_.rate.bin);
      start.time = {.at = first, .low = std::min(start.time.low, first), .high = std::max(start.time.high, first)};
      start.doubt = doubt("onset-with-touch-before", "its onset cannot be distinguished from that of the touch before");
    }
    allow_for_gaps(start.time, "onset");
    allow_for_gaps(end.time, "end");
    if (!start.doubt.empty()) flag(start.doubt, labels_.intervals.size());
    // Learning uses the start of a touch, and no `none` sample lies where its end may be: a doubtful end needs a look only if it
    // may lie far off and soon after the onset. Tips that creep on a little after a press are in its interval.
    const double end_width_ms = in_ms(between(end.time.low, end.time.high));
    const bool end_is_wide = !ends_with_arm && end_width_ms > options_.end.too_wide_ms &&
                             in_ms(between(start.time.at, end.time.low)) < options_.end.too_wide_ms;
    const bool is_worth_a_word = touch == Touch::slip || end_width_ms > 0.5 * options_.end.too_wide_ms;
    if (!end.doubt.empty() && end_is_wide) {
      flag(end.doubt, labels_.intervals.size());
    } else if (!end.doubt.empty() && is_worth_a_word) {
      labels_.remarks.push_back(fmt::format("the {} at {:.0f} ms: {}", name_of(touch),
                                            in_ms(between(signals_.rate.begin, start.time.at)), end.doubt.words));
    }
    labels_.intervals.push_back({.id = {},
                                 .touch = touch,
                                 .start = start.time,
                                 .end = end.time,
                                 .source = "events",
                                 .evidence = {.events = start.time.at, .robot = {}, .video = {}, .imu = {}},
                                 .confirmed = false});
  }

  std::optional<alignment::UncertainTime> earliest_slip(const alignment::Burst& burst) const {
    const ArmMove* lift = lift_around(moves_.lifts, signals_.rate, burst);
    if (lift == nullptr) return std::nullopt;
    return alignment::UncertainTime{lift->start, before(lift->start, lift->uncertainty), after(lift->start, lift->uncertainty)};
  }

  /// Whether the onset is known well enough to learn from, and lies where the lift puts it.
  bool is_confirmed_by_lift(const alignment::UncertainTime& onset, const alignment::Burst& burst) const {
    const ArmMove* lift = lift_around(moves_.lifts, signals_.rate, burst);
    return lift != nullptr && confirms(*lift, onset);
  }

  bool confirms(const ArmMove& lift, const alignment::UncertainTime& onset) const {
    return lift.uncertainty <= well_placed && in_ms(between(onset.low, onset.high)) <= options_.onset.too_wide_ms &&
           is_slip_of(lift, onset.at);
  }

  bool is_slip_of(const ArmMove& lift, CameraTime onset) const {
    const microseconds lag = between(lift.start, onset);
    return lag >= -(lift.uncertainty + options_.earliest_slip) && lag <= lift.uncertainty + options_.latest_slip;
  }

  /// Nothing where it is not known well enough to improve a slip's end. A stop that is known roughly only lengthens a slip whose
  /// tips are no longer seen: it shortens none, since the clock may be wrong.
  std::optional<alignment::UncertainTime> arm_stop(const alignment::Burst& burst) const {
    const ArmMove* lift = lift_around(moves_.lifts, signals_.rate, burst);
    if (lift == nullptr || lift->uncertainty > options_.longest_disagreement) return std::nullopt;
    const bool lasts_longer = signals_.rate.begin_of(burst.end) > after(lift->end, lift->uncertainty + options_.end.rung_out);
    if (lift->uncertainty > well_placed && lasts_longer) return std::nullopt;
    return alignment::UncertainTime{lift->end, before(lift->end, lift->uncertainty), after(lift->end, lift->uncertainty)};
  }

  bool imu_confirms_log() const {
    return std::any_of(clocks_.anchors.begin(), clocks_.anchors.end(), [](const std::vector<alignment::ClockAnchor>& anchors) {
      return std::any_of(anchors.begin(), anchors.end(),
                         [](const alignment::ClockAnchor& anchor) { return anchor.kind == alignment::AnchorKind::imu; });
    });
  }

  void relate_clocks() {
    for (const std::optional<alignment::FittedClock>& piece : clocks_.pieces) {
      if (piece) labels_.robot_clocks.push_back(*piece);
    }
    if (!signals_.video) return;
    alignment::VideoClockFit fit = fit_film_clock(signals_, clocks_, options_.video_clock);
    if (!fit.contradiction.empty() && !imu_confirms_log()) {
      flag(fit.contradiction);
      return;
    }
    if (!fit.clock) {
      labels_.remarks.push_back("the film's clock is not related: " + fit.refused);
      return;
    }
    labels_.video_clock = std::move(fit.clock);
    if (!fit.remark.empty()) labels_.remarks.push_back(std::move(fit.remark));
    if (const auto later = skin_in_film_disagrees(signals_, clocks_, *labels_.video_clock, options_.video_clock,
                                                  options_.longest_disagreement)) {
      flag(doubt("film-unlike-skin",
                 "the film's motions match the skin's bursts {:.2f} s {} the time at which the robot's clock puts them",
                 1e-3 * std::abs(in_ms(*later)), *later > 0us ? "after" : "before"));
    }
    video_motions_ = alignment::video_motions(*signals_.video, *labels_.video_clock);
  }

  void witness(std::size_t index) {
    LabelledInterval& interval = labels_.intervals[index];
    // The film shows the stage before it touches, and the arm that rises as the slip starts.
    std::optional<alignment::UncertainTime> filmed;
    if (interval.touch == Touch::press) {
      interval.evidence.robot = stage_command(signals_, clocks_, interval.start.at);
      filmed = alignment::video_start_around(video_motions_, interval.start);  // of the stage
    } else {
      filmed = alignment::video_start_near(video_motions_, interval.start, options_.longest_disagreement);
      if (const ArmMove* lift = lift_of(moves_, interval)) {
        interval.evidence.robot = lift->start;
        interval.evidence.imu = lift_by_imu(*lift);
        compare_with_lift(index, *lift);
      }
    }
    if (filmed) {
      interval.evidence.video = filmed->at;
    } else if (interval.touch == Touch::slip && labels_.video_clock && filmed_at(interval) &&
               !alignment::video_rises_near(*signals_.video, *labels_.video_clock, interval.start.at,
                                            options_.longest_disagreement)) {
      // A stage that closes slowly on an object of the same grey shows in few films; an arm that rises shows in any.
      const Doubt unseen = doubt("slip-not-in-film", "the film shows nothing that rises within {:.0f} ms of this slip's start",
                                 in_ms(options_.longest_disagreement));
      const ArmMove* lift = lift_of(moves_, interval);
      const bool lift_agrees =
          lift != nullptr && lift->uncertainty <= options_.longest_disagreement && is_slip_of(*lift, interval.start.at);
      lift_agrees ? labels_.remarks.push_back(unseen.words) : flag(unseen, index);
    }
  }

  void compare_with_lift(std::size_t index, const ArmMove& lift) {
    const LabelledInterval& slip = labels_.intervals[index];
    const microseconds lag = between(lift.start, slip.start.at);
    if (!is_slip_of(lift, slip.start.at)) {
      flag(doubt(lag < 0us ? "slip-before-lift" : "slip-after-lift",
                 "the slip starts {:.0f} ms {} the lift; expected it from {:.0f} ms before to {:.0f} ms after",
                 std::abs(in_ms(lag)), lag < 0us ? "before" : "after", in_ms(lift.uncertainty + options_.earliest_slip),
                 in_ms(lift.uncertainty + options_.latest_slip)),
           index);
    }
    // Tips that are not seen to move may slide on until the end of the interval.
    const CameraTime stop = after(slip.start.at, between(lift.start, lift.end));
    const microseconds longer = between(stop, std::clamp(stop, slip.end.at, slip.end.high));
    if (std::chrono::abs(longer) > options_.longest_disagreement) {
      flag(doubt(longer > 0us ? "slip-longer-than-lift" : "slip-shorter-than-lift",
                 "the slip lasts {:.0f} ms {} than the lift; expected at most {:.0f} ms between them", std::abs(in_ms(longer)),
                 longer > 0us ? "longer" : "less", in_ms(options_.longest_disagreement)),
           index);
    }
  }

  void look_for_what_is_missing() {
    const auto count = [&](Touch touch) {
      return std::count_if(labels_.intervals.begin(), labels_.intervals.end(),
                           [&](const LabelledInterval& interval) { return interval.touch == touch; });
    };
    const auto slips = static_cast<std::size_t>(count(Touch::slip)) + firm_lifts_;
    // One log may contain several recordings.
    const auto lifts = static_cast<std::size_t>(std::count_if(moves_.lifts.begin(), moves_.lifts.end(), [&](const ArmMove& lift) {
      return lift.end >= signals_.rate.begin && lift.start <= signals_.rate.last;
    }));
    if (moves_.all_placed && slips < lifts) {
      flag(doubt("lifts-without-slip", "{} of the {} lifts during the recording {} without a slip: no burst of events lies in it",
                 lifts - slips, lifts, lifts - slips == 1 ? "is" : "are"));
    } else if (slips == 0 && lifts_are_known() && !moves_.rises) {
      labels_.remarks.emplace_back("no slip, and the robot log has no lift");
    } else if (slips == 0) {
      flag(doubt("no-slip", "no slip found: the event rate has no burst for it"));
    }
    if (count(Touch::press) > 0) return;
    if (nothing_moved_before_lift()) {
      labels_.remarks.emplace_back("no press, and the film shows no motion before the lift");
    } else {
      flag(doubt("no-press", "no press found: the event rate has no burst for it"));
    }
  }

  /// Whether the film shows the whole run up to the lift without motion.
  bool nothing_moved_before_lift() const {
    if (!labels_.video_clock || moves_.lifts.empty()) return false;
    const auto first = std::min_element(moves_.lifts.begin(), moves_.lifts.end(),
                                        [](const ArmMove& a, const ArmMove& b) { return a.start < b.start; });
    const CameraTime until = before(before(first->start, first->uncertainty), frame_of_film);
    return alignment::video_saw_motion(*signals_.video, *labels_.video_clock, signals_.rate.begin, until) == false;
  }

  /// Whether the film shows the whole stretch around the onset.
  bool filmed_at(const LabelledInterval& interval) const {
    const CameraTime t = interval.touch == Touch::press ? interval.end.at : interval.start.at;
    return alignment::video_saw_motion(*signals_.video, *labels_.video_clock, before(t, options_.longest_disagreement),
                                       after(t, options_.longest_disagreement))
        .has_value();
  }

  /// The lift's start by the IMU alone: through this run's anchors of that kind.
  std::optional<CameraTime> lift_by_imu(const ArmMove& lift) const {
    for (std::size_t i = 0; i < clocks_.anchors.size(); ++i) {
      std::vector<alignment::ClockAnchor> by_imu = clocks_.anchors[i];
      std::erase_if(by_imu, [](const alignment::ClockAnchor& anchor) { return anchor.kind != alignment::AnchorKind::imu; });
      if (by_imu.empty() || !clocks_.pieces[i]) continue;
      const std::int64_t lift_us = clocks_.pieces[i]->relation.clock_us_from(lift.start);
      const auto nearest =
          std::min_element(by_imu.begin(), by_imu.end(), [&](const alignment::ClockAnchor& a, const alignment::ClockAnchor& b) {
            return std::abs(a.clock_us - lift_us) < std::abs(b.clock_us - lift_us);
          });
      return after(nearest->camera, microseconds{lift_us - nearest->clock_us});
    }
    return std::nullopt;
  }

  const alignment::RunSignals& signals_;
  const alignment::RobotClocks& clocks_;
  const LabelOptions& options_;
  ArmMoves moves_;
  std::size_t firm_lifts_ = 0;
  std::vector<alignment::VideoMotion> video_motions_;
  Labels labels_;
};

Labels with_provenance(Labels labels, const alignment::RunSignals& signals, const LabelOptions& options) {
  labels.provenance = {{"made_by", "tactile label"},
                       {"settings", settings_of(options)},
                       {"robot_log", robot_log_json(signals)},
                       {"first_event_us", us_of(signals.rate.begin)},
                       {"hot_pixels", signals.rate.hot_pixels},
                       {"quiet_events_per_s", signals.quiet.mean * 1e6 / static_cast<double>(signals.rate.bin.count())}};
  return labels;
}

}  // namespace

Labels label_signals(const alignment::RunSignals& signals, const alignment::RobotClocks& clocks, const LabelOptions& options) {
  return with_provenance(Labeller(signals, clocks, options).labels(), signals, options);
}

Labels label_signals(const alignment::RunSignals& signals, const RunPosterior& posterior, const LabelOptions& options) {
  return with_provenance(posterior_labels(signals, posterior, options.doubt, options.video_clock), signals, options);
}

Labels label_run(const RunFolder& run, const LabelOptions& options) {
  const alignment::RunSignals signals = alignment::read_run_signals(run, options.signals);
  const alignment::RunSignals* const alone = &signals;
  Labels labels = options.method == LabelMethod::model
                      ? label_signals(signals, run_posterior(signals), options)
                      : label_signals(signals, alignment::robot_clocks_of({&alone, 1}, options.clocks).front(), options);
  labels.provenance["inputs"] = alignment::hashes_of_inputs(run);
  return labels;
}

}  // namespace tactile::labels
