#include "tactile/labels/label_run.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "tactile/robot/arm_motion.hpp"

namespace tactile {
namespace {

constexpr microseconds start_and_stop = 500ms;  // recorders of one run may begin and end so far apart
constexpr microseconds well_placed = 30ms;      // a lift whose clock is known so well parts and joins bursts
constexpr microseconds frame_of_film = 50ms;    // a film's motion may show a frame ahead of it

double ms(microseconds span) { return 1e-3 * static_cast<double>(span.count()); }

/// What the arm does, in camera time.
struct ArmMoves {
  std::vector<ArmMove> lifts, taps;
  bool rises = false;      ///< there is a lift in the log
  bool all_placed = true;  ///< the clock of every piece that has one is known
  microseconds logged{0};  ///< time of which the log tells
};

ArmMoves arm_moves(const RunSignals& signals, const RobotClocks& clocks) {
  ArmMoves moves;
  for (std::size_t i = 0; i < signals.robot.size(); ++i) {
    moves.logged += signals.robot[i].log.states.back().t - signals.robot[i].log.states.front().t;
    for (const MotionPhase& phase : signals.robot[i].phases) {
      if (phase.kind != MotionKind::lift && phase.kind != MotionKind::tap) continue;
      const bool is_lift = phase.kind == MotionKind::lift;
      moves.rises = moves.rises || is_lift;
      if (!clocks.pieces[i]) {
        moves.all_placed = moves.all_placed && !is_lift;
        continue;
      }
      const FittedClock& clock = *clocks.pieces[i];
      (is_lift ? moves.lifts : moves.taps)
          .push_back({clock.relation.camera_from(phase.start), clock.relation.camera_from(phase.end), clock.uncertainty()});
    }
  }
  return moves;
}

/// Bursts, those that go on into a lift parted where it begins: an object that is lifted as soon as it is pressed, or tips that
/// spring back just before, leave no quiet between the two.
std::vector<Burst> parted_at(const EventRate& rate, const QuietRate& quiet, std::vector<Burst> bursts,
                             const std::vector<ArmMove>& lifts, const ActivityOptions& options) {
  constexpr microseconds well_before = 60ms;
  for (const ArmMove& lift : lifts) {
    if (lift.uncertainty > well_placed) continue;
    const CameraTime part_at = before(lift.start, lift.uncertainty);
    const auto parted = std::find_if(bursts.begin(), bursts.end(), [&](const Burst& burst) {
      return rate.begin_of(burst.begin) < before(part_at, well_before) && rate.begin_of(burst.end) > lift.start;
    });
    if (parted == bursts.end()) continue;
    const auto place = static_cast<std::size_t>(between(rate.begin, part_at) / rate.bin);
    EventRate ahead = rate;
    ahead.counts.resize(place);
    std::vector<Burst> parts = bursts_in(ahead, quiet, options);
    std::erase_if(parts, [&](const Burst& part) { return part.end <= parted->begin; });
    Burst rest = *parted;
    rest.begin = place;
    rest.events = events_above(rate, quiet, rest.begin, rest.end);
    parts.push_back(rest);
    bursts.insert(bursts.erase(parted), parts.begin(), parts.end());
  }
  return bursts;
}

/// Bursts that begin within a lift made one: an object may stick for longer than what parts two bursts.
std::vector<Burst> joined_in(const EventRate& rate, const QuietRate& quiet, std::vector<Burst> bursts,
                             const std::vector<ArmMove>& lifts) {
  for (const ArmMove& lift : lifts) {
    if (lift.uncertainty > well_placed) continue;
    const auto is_within = [&](const Burst& burst) {
      const CameraTime begin = rate.begin_of(burst.begin);
      return begin >= before(lift.start, lift.uncertainty) && begin < lift.end;
    };
    const auto first = std::find_if(bursts.begin(), bursts.end(), is_within);
    if (first == bursts.end()) continue;
    const auto behind = std::find_if_not(first, bursts.end(), is_within);
    first->end = std::prev(behind)->end;
    first->events = events_above(rate, quiet, first->begin, first->end);
    bursts.erase(std::next(first), behind);
  }
  return bursts;
}

/// The command ahead of a press that made it: the last change of an output to a greater value within two seconds.
std::optional<CameraTime> stage_command(const RunSignals& signals, const RobotClocks& clocks, CameraTime press) {
  constexpr microseconds longest_way = 2s;
  std::optional<CameraTime> command;
  for (std::size_t i = 0; i < signals.robot.size(); ++i) {
    if (!clocks.pieces[i]) continue;
    for (const OutputChange& change : signals.robot[i].log.output_changes) {
      const CameraTime at = clocks.pieces[i]->relation.camera_from(change.at);
      if (change.to > change.from && at <= press && at >= before(press, longest_way))
        command = std::max(command.value_or(at), at);
    }
  }
  return command;
}

/// What the film must have seen of the arm: by the first piece of the log whose clock is known.
std::optional<SeenMotion> arm_in_film(const RunSignals& signals, const RobotClocks& clocks) {
  for (std::size_t i = 0; i < signals.robot.size(); ++i) {
    const std::optional<ArmMotion> motion = arm_motion(signals.robot[i].log);
    if (motion && clocks.pieces[i]) return seen_motion(*motion, *clocks.pieces[i]);
  }
  return std::nullopt;
}

/// Relates the film's clock by the arm, or, where no log tells of it, by the bursts of events.
VideoClockFit fitted_video_clock(const RunSignals& signals, const RobotClocks& clocks, const VideoClockOptions& options) {
  // Without its end a film may show one motion where another is looked for.
  if (10 * signals.video->rows_without_frame > signals.video->frames)
    return {.clock = {}, .refused = "the film lacks frames", .likeness = 0, .ambiguity = 0, .anchors = {}};
  const bool moves =
      std::any_of(signals.robot.begin(), signals.robot.end(), [](const RobotPiece& piece) { return !piece.phases.empty(); });
  const std::optional<SeenMotion> seen_arm = arm_in_film(signals, clocks);
  if (moves && seen_arm) return fit_video_clock(*signals.video, *seen_arm, options);
  std::vector<SeenBurst> seen;
  for (const Burst& burst : signals.bursts)
    seen.push_back({signals.rate.begin_of(burst.begin), signals.rate.begin_of(burst.end)});
  return fit_video_clock(*signals.video, seen, options);
}

const ArmMove* lift_of(const ArmMoves& moves, const LabelledInterval& slip) {
  const auto nearest = std::min_element(moves.lifts.begin(), moves.lifts.end(), [&](const ArmMove& a, const ArmMove& b) {
    return std::chrono::abs(between(a.start, slip.start.at)) < std::chrono::abs(between(b.start, slip.start.at));
  });
  return nearest == moves.lifts.end() ? nullptr : &*nearest;
}

void cut_overlaps(std::vector<LabelledInterval>& intervals) {
  for (std::size_t i = 0; i + 1 < intervals.size(); ++i) {
    UncertainTime& end = intervals[i].end;
    const CameraTime next = intervals[i + 1].start.at;
    end = {std::min(end.at, next), std::min(end.low, next), std::min(end.high, next)};
  }
}

/// Makes a run's labels, step by step.
class Labeller {
 public:
  Labeller(const RunSignals& signals, const RobotClocks& clocks, const LabelOptions& options)
      : signals_(signals), clocks_(clocks), options_(options), moves_(arm_moves(signals, clocks)) {}

  Labels labels() {
    for (const std::string& problem : signals_.problems) flag(problem);
    labels_.remarks = signals_.remarks;
    // What one anchor leaves open is no matter where another has settled it, or where there is nothing to place.
    for (const std::string& doubt : clocks_.doubts) a_clock_is_refused() ? flag(doubt) : labels_.remarks.push_back(doubt);
    if (!signals_.has_robot) {
      flag("no robot log: press and slip are told apart by their order alone");
    } else if (!lifts_are_known() && !moves_.rises) {
      flag(fmt::format(
          "the robot log has no lift, but only {:.2f} s of the recording's {:.2f} s: press and slip are told apart by "
          "their order alone",
          1e-3 * ms(moves_.logged), 1e-3 * ms(recorded())));
    }

    find_intervals();
    relate_clocks();
    for (std::size_t i = 0; i < labels_.intervals.size(); ++i) witness(i);
    look_for_what_is_missing();
    cut_overlaps(labels_.intervals);
    name_intervals(labels_.intervals);
    labels_.provenance = {{"made_by", "tactile label"},
                          {"settings", settings_of(options_)},
                          {"robot_log", robot_log_json()},
                          {"first_event_us", us_of(signals_.rate.begin)},
                          {"hot_pixels", signals_.rate.hot_pixels},
                          {"quiet_events_per_s", signals_.quiet.mean * 1e6 / static_cast<double>(signals_.rate.bin.count())}};
    return std::move(labels_);
  }

 private:
  void flag(std::string reason, std::optional<std::size_t> interval_index = std::nullopt) {
    labels_.flags.push_back({.interval_index = interval_index, .reason = std::move(reason), .confirmed = false});
  }

  /// A piece of the log in which something happens has no clock.
  bool a_clock_is_refused() const {
    for (std::size_t i = 0; i < signals_.robot.size(); ++i) {
      const RobotPiece& piece = signals_.robot[i];
      if (!clocks_.pieces[i] && !(piece.phases.empty() && piece.log.output_changes.empty())) return true;
    }
    return false;
  }

  /// What the arm's motions were taken from.
  nlohmann::json robot_log_json() const {
    if (!signals_.has_robot) return nullptr;
    return {{"speeds_from", name_of(signals_.speed_from)},
            {"arm_model", signals_.arm ? nlohmann::json(name_of(*signals_.arm)) : nlohmann::json(nullptr)}};
  }

  microseconds recorded() const { return between(signals_.rate.begin, signals_.rate.last); }

  /// True if the log tells of every lift, be there none: a log that is shorter than the recording may lack it.
  bool lifts_are_known() const { return moves_.all_placed && (moves_.rises || moves_.logged + start_and_stop >= recorded()); }

  void find_intervals() {
    RecordingReader recording(signals_.run.events());
    const std::vector<Burst> bursts = joined_in(
        signals_.rate, signals_.quiet,
        parted_at(signals_.rate, signals_.quiet, signals_.bursts, moves_.lifts, options_.signals.activity), moves_.lifts);
    const std::vector<LitRate> lit = lit_rates(recording, signals_.event_stream, signals_.rate, bursts);
    std::vector<double> undoes;
    for (const LitRate& burst : lit) undoes.push_back(burst.undoes);
    const std::vector<BurstKind> kinds =
        kinds_of(signals_.rate, bursts, lifts_are_known() ? std::optional(moves_.lifts) : std::nullopt, moves_.taps, undoes,
                 options_.touches);
    for (std::size_t i = 0; i < bursts.size(); ++i) {
      if (kinds[i] != BurstKind::slip && !is_after_effect(bursts[i], signals_.rate, bursts)) tell_if_unlogged(bursts[i]);
      if (kinds[i] == BurstKind::press) {
        const FoundTime onset = press_onset(lit[i], options_.onset);
        add(Touch::press, onset, press_end(lit[i], onset.time, options_.end));
      } else if (kinds[i] == BurstKind::slip) {
        const FoundTime onset = slip_onset(lit[i], options_.onset, earliest_slip(bursts[i]));
        add(Touch::slip, onset, slip_end(lit[i], onset.time, options_.end, arm_stop(bursts[i])));
      }
    }
  }

  /// A burst behind the log's end may be the slip of a lift that nobody logged.
  void tell_if_unlogged(const Burst& burst) {
    std::optional<CameraTime> logged_until;
    for (std::size_t i = 0; i < signals_.robot.size(); ++i) {
      if (!clocks_.pieces[i]) return;
      const CameraTime end =
          after(clocks_.pieces[i]->relation.camera_from(signals_.robot[i].log.states.back().t), clocks_.pieces[i]->uncertainty());
      logged_until = std::max(logged_until.value_or(end), end);
    }
    const CameraTime begin = signals_.rate.begin_of(burst.begin);
    if (!logged_until || begin <= *logged_until) return;
    flag(fmt::format(
        "the robot log ends {:.2f} s ahead of the burst of events at {:.2f} s: whether the arm rose then is not known",
        1e-3 * ms(between(*logged_until, begin)), 1e-3 * ms(between(signals_.rate.begin, begin))));
  }

  /// What began or ended in a gap is found at its rim: it may lie anywhere within.
  void allow_for_gaps(UncertainTime& t, const std::string& what) {
    constexpr microseconds near = 20ms;
    for (const CameraSpan& gap : signals_.gaps) {
      if (gap.begin > after(t.high, near) || gap.end < before(t.low, near)) continue;
      t.low = std::min(t.low, gap.begin);
      t.high = std::max(t.high, gap.end);
      flag(fmt::format("its {} may lie in the recording's gap of {:.0f} ms", what, ms(between(gap.begin, gap.end))),
           labels_.intervals.size());
    }
  }

  void add(Touch touch, FoundTime start, FoundTime end) {
    allow_for_gaps(start.time, "onset");
    allow_for_gaps(end.time, "end");
    if (!start.doubt.empty()) flag(start.doubt, labels_.intervals.size());
    // What is kept of a touch for learning is its begin: a doubtful end needs a look only if it may be far off.
    const bool end_is_wide = ms(between(end.time.low, end.time.high)) > options_.end.too_wide_ms;
    if (!end.doubt.empty() && end_is_wide) flag(end.doubt, labels_.intervals.size());
    if (!end.doubt.empty() && !end_is_wide) {
      labels_.remarks.push_back(fmt::format("the {} at {} us: {}", name_of(touch), us_of(start.time.at), end.doubt));
    }
    labels_.intervals.push_back({.id = {},
                                 .touch = touch,
                                 .start = start.time,
                                 .end = end.time,
                                 .source = "events",
                                 .evidence = {.events = start.time.at, .robot = {}, .video = {}, .imu = {}},
                                 .confirmed = false});
  }

  /// The lift that the burst lies in.
  const ArmMove* lift_around(const Burst& burst) const {
    const auto overlaps = [&](const ArmMove& lift) {
      return signals_.rate.begin_of(burst.begin) < after(lift.end, lift.uncertainty) &&
             signals_.rate.begin_of(burst.end) > before(lift.start, lift.uncertainty);
    };
    const auto lift = std::find_if(moves_.lifts.begin(), moves_.lifts.end(), overlaps);
    return lift == moves_.lifts.end() ? nullptr : &*lift;
  }

  std::optional<UncertainTime> earliest_slip(const Burst& burst) const {
    const ArmMove* lift = lift_around(burst);
    if (lift == nullptr) return std::nullopt;
    return UncertainTime{lift->start, before(lift->start, lift->uncertainty), after(lift->start, lift->uncertainty)};
  }

  /// Where it is known well enough to say more of a slip's end than the events do.
  std::optional<UncertainTime> arm_stop(const Burst& burst) const {
    const ArmMove* lift = lift_around(burst);
    if (lift == nullptr || lift->uncertainty > well_placed) return std::nullopt;
    return UncertainTime{lift->end, before(lift->end, lift->uncertainty), after(lift->end, lift->uncertainty)};
  }

  void relate_clocks() {
    for (const std::optional<FittedClock>& piece : clocks_.pieces) {
      if (piece) labels_.robot_clocks.push_back(*piece);
    }
    if (!signals_.video) return;
    VideoClockFit fit = fitted_video_clock(signals_, clocks_, options_.video_clock);
    if (!fit.clock) {
      labels_.remarks.push_back("the film's clock is not related: " + fit.refused);
      return;
    }
    labels_.video_clock = std::move(fit.clock);
    video_motions_ = video_motions(*signals_.video, *labels_.video_clock);
  }

  void witness(std::size_t index) {
    LabelledInterval& interval = labels_.intervals[index];
    // The film sees the stage that goes on to touch, and the arm rise as the slip starts.
    std::optional<UncertainTime> filmed;
    if (interval.touch == Touch::press) {
      interval.evidence.robot = stage_command(signals_, clocks_, interval.start.at);
      filmed = filmed_stage(interval.start);
    } else {
      filmed = video_start_near(video_motions_, interval.start, options_.longest_disagreement);
      if (const ArmMove* lift = lift_of(moves_, interval)) {
        interval.evidence.robot = lift->start;
        interval.evidence.imu = felt_lift(*lift);
        compare_with_lift(index, *lift);
      }
    }
    if (filmed) {
      interval.evidence.video = filmed->at;
    } else if (interval.touch == Touch::slip && labels_.video_clock && filmed_at(interval)) {
      // A stage that closes slowly on an object of its own grey shows in few films; an arm that rises shows in any.
      flag(fmt::format("the film sees nothing rise within {:.0f} ms of this slip's start", ms(options_.longest_disagreement)),
           index);
    }
  }

  /// When the motion began, in the film, in which the press starts: that of the stage.
  std::optional<UncertainTime> filmed_stage(const UncertainTime& onset) const {
    const auto holds = [&](const VideoMotion& motion) {
      return !motion.start_cut && motion.start.low <= onset.high && motion.end.high >= onset.low;
    };
    const auto motion = std::find_if(video_motions_.begin(), video_motions_.end(), holds);
    return motion == video_motions_.end() ? std::nullopt : std::optional(motion->start);
  }

  void compare_with_lift(std::size_t index, const ArmMove& lift) {
    const LabelledInterval& slip = labels_.intervals[index];
    const microseconds lag = between(lift.start, slip.start.at);
    if (lag < -(lift.uncertainty + options_.earliest_slip) || lag > lift.uncertainty + options_.latest_slip) {
      flag(fmt::format("the slip starts {:.0f} ms {} the lift; expected it from {:.0f} ms before to {:.0f} ms after",
                       std::abs(ms(lag)), lag < 0us ? "before" : "after", ms(lift.uncertainty + options_.earliest_slip),
                       ms(lift.uncertainty + options_.latest_slip)),
           index);
    }
    const microseconds longer = between(slip.start.at, slip.end.at) - between(lift.start, lift.end);
    if (std::chrono::abs(longer) > options_.longest_disagreement) {
      flag(fmt::format("the slip lasts {:.0f} ms {} than the lift; expected at most {:.0f} ms between them", std::abs(ms(longer)),
                       longer > 0us ? "longer" : "less", ms(options_.longest_disagreement)),
           index);
    }
  }

  void look_for_what_is_missing() {
    const auto count = [&](Touch touch) {
      return std::count_if(labels_.intervals.begin(), labels_.intervals.end(),
                           [&](const LabelledInterval& interval) { return interval.touch == touch; });
    };
    const auto slips = static_cast<std::size_t>(count(Touch::slip));
    if (moves_.all_placed && slips < moves_.lifts.size()) {
      flag(fmt::format("{} of the {} lifts in the robot log {} without a slip: no burst of events lies in it",
                       moves_.lifts.size() - slips, moves_.lifts.size(), moves_.lifts.size() - slips == 1 ? "is" : "are"));
    } else if (slips == 0 && lifts_are_known() && !moves_.rises) {
      labels_.remarks.emplace_back("no slip, and the robot log has no lift");
    } else if (slips == 0) {
      flag("no slip found: the event rate has no burst for it");
    }
    if (count(Touch::press) > 0) return;
    if (nothing_moved_ahead()) {
      labels_.remarks.emplace_back("no press, and the film sees nothing move ahead of the lift");
    } else {
      flag("no press found: the event rate has no burst for it");
    }
  }

  /// True if the film shows the whole run up to the lift, and nothing in it moves.
  bool nothing_moved_ahead() const {
    if (!labels_.video_clock || moves_.lifts.empty()) return false;
    const auto first = std::min_element(moves_.lifts.begin(), moves_.lifts.end(),
                                        [](const ArmMove& a, const ArmMove& b) { return a.start < b.start; });
    const CameraTime until = before(before(first->start, first->uncertainty), frame_of_film);
    return video_saw_motion(*signals_.video, *labels_.video_clock, signals_.rate.begin, until) == false;
  }

  /// True if the film shows the stretch around the onset whole.
  bool filmed_at(const LabelledInterval& interval) const {
    const CameraTime t = interval.touch == Touch::press ? interval.end.at : interval.start.at;
    return video_saw_motion(*signals_.video, *labels_.video_clock, before(t, options_.longest_disagreement),
                            after(t, options_.longest_disagreement))
        .has_value();
  }

  /// The lift's start by the inertial sensor alone: through this run's anchors of that kind.
  std::optional<CameraTime> felt_lift(const ArmMove& lift) const {
    for (std::size_t i = 0; i < clocks_.anchors.size(); ++i) {
      std::vector<ClockAnchor> felt = clocks_.anchors[i];
      std::erase_if(felt, [](const ClockAnchor& anchor) { return anchor.kind != AnchorKind::imu; });
      if (felt.empty() || !clocks_.pieces[i]) continue;
      const std::int64_t lift_us = clocks_.pieces[i]->relation.clock_us_from(lift.start);
      const auto nearest = std::min_element(felt.begin(), felt.end(), [&](const ClockAnchor& a, const ClockAnchor& b) {
        return std::abs(a.clock_us - lift_us) < std::abs(b.clock_us - lift_us);
      });
      return after(nearest->camera, microseconds{lift_us - nearest->clock_us});
    }
    return std::nullopt;
  }

  const RunSignals& signals_;
  const RobotClocks& clocks_;
  const LabelOptions& options_;
  ArmMoves moves_;
  std::vector<VideoMotion> video_motions_;
  Labels labels_;
};

}  // namespace

nlohmann::json settings_of(const LabelOptions& options) {
  nlohmann::json region;
  if (const auto& r = options.signals.video.region) region = {r->x, r->y, r->width, r->height};
  const AnchorOptions& anchors = options.clocks.anchors;
  const ClockFitOptions& fit = options.clocks.fit;
  return {{"rate",
           {{"bin_us", options.signals.rate.bin.count()},
            {"hot_pixel_hz", options.signals.rate.hot_pixel_hz},
            {"flickers", options.signals.rate.flickers}}},
          {"activity",
           {{"smoothing_us", options.signals.activity.smoothing.count()},
            {"enter", options.signals.activity.enter},
            {"leave", options.signals.activity.leave},
            {"merge_us", options.signals.activity.merge.count()},
            {"shortest_us", options.signals.activity.shortest.count()}}},
          {"shortest_gap_us", options.signals.shortest_gap.count()},
          {"video", {{"width", options.signals.video.width}, {"region", region}}},
          {"touches", {{"releases", options.touches.releases}, {"shortest_press_us", options.touches.shortest_press.count()}}},
          {"onset",
           {{"before_us", options.onset.before.count()},
            {"first_contact_us", options.onset.first_contact.count()},
            {"rise_us", options.onset.rise.count()},
            {"first_drag_us", options.onset.first_drag.count()},
            {"latency_us", options.onset.latency.count()},
            {"longest_blind_us", options.onset.longest_blind.count()},
            {"blind_anew_us", options.onset.blind_anew.count()},
            {"too_wide_ms", options.onset.too_wide_ms}}},
          {"end",
           {{"still_share", options.end.still_share},
            {"press_still_us", options.end.press_still.count()},
            {"slip_still_us", options.end.slip_still.count()},
            {"rung_out_us", options.end.rung_out.count()},
            {"stick_phase_us", options.end.stick_phase.count()},
            {"least_error_us", options.end.least_error.count()},
            {"too_wide_ms", options.end.too_wide_ms}}},
          {"anchors",
           {{"grid_us", anchors.grid.count()},
            {"ambiguous_below", anchors.ambiguous_below},
            {"least_likeness", anchors.least_likeness},
            {"most_slack_m", anchors.most_slack_m},
            {"stage_delay_us", anchors.stage_delay.count()}}},
          {"clock_fit",
           {{"most_drift_ppm", fit.most_drift_ppm},
            {"usual_drift_ppm", fit.usual_drift_ppm},
            {"drift_needs_anchors", fit.drift_needs_anchors},
            {"drift_needs_span_us", fit.drift_needs_span.count()},
            {"reject_beyond", fit.reject_beyond}}},
          {"video_clock",
           {{"coarse_offset_us", options.video_clock.coarse_offset_us ? nlohmann::json(*options.video_clock.coarse_offset_us)
                                                                      : nlohmann::json(nullptr)},
            {"search_us", options.video_clock.search.count()},
            {"least_likeness", options.video_clock.least_likeness},
            {"least_ambiguity", options.video_clock.least_ambiguity},
            {"most_disagreement_us", options.video_clock.most_disagreement_us}}},
          {"longest_disagreement_us", options.longest_disagreement.count()},
          {"latest_slip_us", options.latest_slip.count()},
          {"earliest_slip_us", options.earliest_slip.count()}};
}

Labels label_signals(const RunSignals& signals, const RobotClocks& clocks, const LabelOptions& options) {
  return Labeller(signals, clocks, options).labels();
}

Labels label_run(const RunFolder& run, const LabelOptions& options) {
  const RunSignals signals = read_run_signals(run, options.signals);
  const RunSignals* const alone = &signals;
  Labels labels = label_signals(signals, robot_clocks_of({&alone, 1}, options.clocks).front(), options);
  labels.provenance["inputs"] = hashes_of_inputs(run);
  return labels;
}

}  // namespace tactile
