#include "tactile/evaluation/run_judge.hpp"

#include <algorithm>
#include <array>

#include "tactile/core/duration_units.hpp"

namespace tactile::evaluation {
namespace {

constexpr microseconds again_after{500'000};  // an episode counts again for each further one outside of touches
constexpr microseconds echo{100'000};         // what ended within it may still be the cause of an alarm
constexpr microseconds lift_time{500'000};    // from the start of a lift; gross slip comes some 20 ms after the first shear

constexpr microseconds first_part{500'000}, last_part{200'000};  // of a touch, as in figure 10 of the paper

/// How often an episode counts that was outside of touches for a time.
std::uint64_t counts_of(bool begins_here, microseconds outside) {
  if (!begins_here) return static_cast<std::uint64_t>(outside / again_after);
  // The tick that ends a whole `again_after` does not begin the next one.
  return 1 + static_cast<std::uint64_t>(std::max(outside - microseconds{1}, microseconds{0}) / again_after);
}

results::TouchOutcome outcome_of(const results::Detection& detection, const std::optional<CameraTime>& gross) {
  const bool is_detected = detection.outcome == results::DetectionOutcome::detected;
  results::TouchOutcome outcome{
      .touch = detection.interval.touch,
      .outcome = detection.outcome,
      .ms = in_ms(is_detected ? between(detection.interval.start, detection.first_right) : detection.limit)};
  if (gross)
    outcome.gross_ms =
        in_ms(between(*gross, is_detected ? detection.first_right : after(detection.interval.start, detection.limit)));
  return outcome;
}

}  // namespace

std::vector<Episode> episodes_in(std::span<const Touch> verdicts) {
  std::vector<Episode> episodes;
  for (std::size_t i = 0; i < verdicts.size(); ++i) {
    if (verdicts[i] == Touch::none) continue;
    const auto index = static_cast<std::int64_t>(i);
    if (i > 0 && verdicts[i - 1] == verdicts[i]) {
      episodes.back().last = index;
    } else {
      episodes.push_back({verdicts[i], index, index});
    }
  }
  return episodes;
}

Course course_by_labels(const RunTruth& truth) {
  Course course;
  for (const windows::SampledInterval& label : truth.labels)
    (label.used ? course.touches : course.in_doubt).push_back(label.interval);
  course.gross.resize(course.touches.size());
  for (const TouchInterval& release : truth.releases) course.motions.push_back({release, "release"});
  return course;
}

Course course_of(const RunTruth& truth) {
  if (!truth.has_truth) return course_by_labels(truth);
  Course course;
  course.by_truth = true;
  course.touches = truth.true_ones;
  course.gross = truth.gross;
  for (std::size_t i = 0; i < truth.unlabelled.size(); ++i)
    course.motions.push_back({truth.unlabelled[i], i < truth.causes.size() ? truth.causes[i] : "unlabelled motion"});
  const bool slips = std::any_of(course.touches.begin(), course.touches.end(),
                                 [](const TouchInterval& touch) { return touch.touch == Touch::slip; });
  if (!slips) course.lift_without_slip = truth.lift;
  return course;
}

RunJudge::RunJudge(const TickRange& ticks, const Course& course, const DelayOptions& options)
    : ticks_(ticks), course_(course), options_(options) {
  const auto any_holds = [](const std::vector<TouchInterval>& intervals, CameraTime t) {
    return std::any_of(intervals.begin(), intervals.end(), [t](const TouchInterval& one) { return one.contains(t); });
  };
  places_.reserve(static_cast<std::size_t>(std::max<std::int64_t>(ticks.count, 0)));
  std::vector<TouchInterval> in_doubt = course.in_doubt;
  for (TouchInterval& touch : in_doubt) touch.start = before(touch.start, options.head_start);
  for (std::int64_t i = 0; i < ticks.count; ++i) {
    const CameraTime t = ticks.at(i);
    places_.push_back(any_holds(course.touches, t) ? Place::in_touch : any_holds(in_doubt, t) ? Place::in_doubt : Place::outside);
  }
}

std::string RunJudge::cause_at(CameraTime t) const {
  const Course::Motion* going_on = nullptr;
  std::string cause = "quiet";
  CameraTime latest_end = before(t, echo);
  const auto see_end = [&](const TouchInterval& interval, std::string_view name) {
    if (interval.end >= t || interval.end < latest_end) return;
    latest_end = interval.end;
    cause = name;
  };
  for (const Course::Motion& motion : course_.motions) {
    if (motion.interval.contains(t) && (going_on == nullptr || motion.interval.start >= going_on->interval.start))
      going_on = &motion;
    see_end(motion.interval, motion.cause);
  }
  for (const std::vector<TouchInterval>* touches : {&course_.touches, &course_.in_doubt}) {
    for (const TouchInterval& touch : *touches) see_end(touch, "after an end");
  }
  return going_on != nullptr ? going_on->cause : cause;
}

void RunJudge::add_alarms(results::Cell& cell, const Episode& episode, std::span<const results::Detection> detections) const {
  const auto led_to = [&](results::DetectionOutcome outcome) {
    return std::any_of(detections.begin(), detections.end(), [&](const results::Detection& detection) {
      return detection.leading_episode == episode.first && detection.outcome == outcome;
    });
  };
  std::int64_t outside = 0;
  std::optional<std::int64_t> first_outside;
  for (std::int64_t i = episode.first; i <= episode.last; ++i) {
    if (!is_outside(i)) continue;
    ++outside;
    if (!first_outside) first_outside = i;
  }
  const bool made_early = led_to(results::DetectionOutcome::early);
  const bool detects = !made_early && led_to(results::DetectionOutcome::detected);
  const bool begins = made_early || (!detects && is_outside(episode.first));
  if (const std::uint64_t alarms = counts_of(begins, ticks_.tick * outside); alarms > 0)
    cell.alarms[cause_at(ticks_.at(first_outside.value_or(episode.first)))] += alarms;
}

void RunJudge::add_right_ticks(results::Cell& cell, std::span<const Touch> verdicts) const {
  for (std::size_t i = 0; i < places_.size(); ++i) {
    if (places_[i] != Place::in_touch) continue;
    const CameraTime t = ticks_.at(static_cast<std::int64_t>(i));
    const TouchInterval& touch =
        *std::find_if(course_.touches.begin(), course_.touches.end(), [t](const TouchInterval& one) { return one.contains(t); });
    const auto add = [&](results::TickCount& counts) {
      ++counts.ticks;
      counts.right += verdicts[i] == touch.touch ? 1 : 0;
    };
    if (between(touch.start, t) <= first_part) add(cell.first);
    if (between(touch.start, touch.end) > last_part) add(between(t, touch.end) < last_part ? cell.last : cell.before_last);
  }
}

results::Cell RunJudge::judged(std::span<const Touch> verdicts) const {
  const std::vector<results::Detection> detections = detections_of(ticks_, verdicts, course_.touches, options_);
  results::Cell cell;
  cell.tick_ms = in_ms(ticks_.tick);
  cell.by_truth = course_.by_truth;
  for (const Touch touch : {Touch::press, Touch::slip}) {
    for (std::size_t i = 0; i < detections.size(); ++i) {
      if (detections[i].interval.touch == touch)
        cell.touches.push_back(outcome_of(detections[i], touch == Touch::slip ? course_.gross[i] : std::nullopt));
    }
  }
  std::int64_t outside = 0, in_alarm = 0;
  for (std::size_t i = 0; i < places_.size(); ++i) {
    outside += places_[i] == Place::outside ? 1 : 0;
    in_alarm += places_[i] == Place::outside && verdicts[i] != Touch::none ? 1 : 0;
  }
  cell.outside_s = in_s(ticks_.tick * outside);
  cell.in_alarm_s = in_s(ticks_.tick * in_alarm);
  add_right_ticks(cell, verdicts);
  if (course_.lift_without_slip) cell.false_slips = 0;
  for (const Episode& episode : episodes_in(verdicts)) {
    const CameraTime first = ticks_.at(episode.first);
    add_alarms(cell, episode, detections);
    const bool is_of_its_touch = std::any_of(detections.begin(), detections.end(), [&](const results::Detection& detection) {
      return detection.leading_episode == episode.first;
    });
    cell.wrong_class +=
        !is_of_its_touch && std::any_of(course_.touches.begin(), course_.touches.end(), [&](const TouchInterval& touch) {
          return touch.touch != episode.touch && touch.contains(first);
        });
    if (cell.false_slips && episode.touch == Touch::slip && ticks_.at(episode.last) > *course_.lift_without_slip &&
        first <= after(*course_.lift_without_slip, lift_time))
      ++*cell.false_slips;
  }
  return cell;
}

std::span<const double> curve_thresholds() {
  static const auto thresholds = [] {
    std::array<double, 41> all{};
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = -4 + 0.5 * static_cast<double>(i);
    return all;
  }();
  return thresholds;
}

std::vector<results::Cell> judged_along_curve(const RunJudge& judge, microseconds tick, std::span<const Touch> verdicts,
                                              std::span<const model::Probabilities> probabilities,
                                              const std::optional<model::TwoThresholds>& thresholds) {
  std::vector<results::Cell> cells{judge.judged(verdicts)};
  std::vector<Touch> others(verdicts.size());
  for (const double threshold : curve_thresholds()) {
    model::ThresholdDecision decision(model::moved_to({}, threshold), tick);
    std::transform(probabilities.begin(), probabilities.end(), others.begin(),
                   [&](const model::Probabilities& of_tick) { return decision.next(of_tick); });
    cells.push_back(judge.judged(others));
    cells.back().threshold = threshold;
  }
  if (!thresholds) return cells;
  const auto add_confirmed = [&](double confirmed, std::optional<double> threshold) {
    model::TwoThresholds settings = *thresholds;
    settings.confirmed = confirmed;
    model::ThresholdDecision decision(settings, tick);
    std::transform(probabilities.begin(), probabilities.end(), others.begin(), [&](const model::Probabilities& of_tick) {
      decision.next(of_tick);
      return decision.confirms_slip() ? Touch::slip : Touch::none;
    });
    results::Cell& cell = cells.emplace_back(judge.judged(others));
    std::erase_if(cell.touches, [](const results::TouchOutcome& touch) { return touch.touch == Touch::press; });
    cell.confirmed = true;
    cell.threshold = threshold;
  };
  add_confirmed(thresholds->confirmed, {});
  for (const double threshold : curve_thresholds()) {
    if (threshold >= thresholds->on) add_confirmed(threshold, threshold);
  }
  return cells;
}

}  // namespace tactile::evaluation
