#include "tactile/evaluation/run_truth.hpp"

#include <algorithm>
#include <filesystem>

#include "tactile/core/error.hpp"
#include "tactile/core/truth.hpp"
#include "tactile/labels/labels.hpp"

namespace tactile::evaluation {
namespace {

/// What an alarm in this motion is due to: as the truth names it, but a lift without slip by its name in the laboratory.
std::string cause_of(const TrueInterval& motion) {
  if (motion.what.empty()) return "unlabelled motion";
  return motion.what == "firm shear" ? "firm lift" : motion.what;
}

}  // namespace

std::vector<TouchInterval> RunTruth::all_labelled() const {
  std::vector<TouchInterval> all;
  for (const windows::SampledInterval& label : labels) all.push_back(label.interval);
  return all;
}

std::vector<TouchInterval> RunTruth::used() const {
  std::vector<TouchInterval> ones;
  for (const windows::SampledInterval& label : labels) {
    if (label.used) ones.push_back(label.interval);
  }
  return ones;
}

RunTruth read_run_truth(const RunFolder& run, bool include_flagged) {
  RunTruth truth;
  if (std::filesystem::exists(run.labels())) {
    const labels::Labels labels = labels::read_labels(run.labels());
    truth.has_labels = true;
    truth.run_is_flagged = labels.run_is_flagged();
    truth.releases = labels.releases;
    truth.unclear = labels::unclear_motion(labels);
    for (std::size_t i = 0; i < labels.intervals.size(); ++i) {
      truth.visible.push_back(labels.intervals[i].visible);
      truth.labels.push_back({labels.intervals[i].interval(), include_flagged || !labels.interval_is_flagged(i)});
    }
  }
  truth.has_truth = std::filesystem::exists(run.truth());
  if (!truth.has_truth) return truth;
  const Truth read = read_truth(run.truth());
  truth.lift = read.lift_start;
  if (const auto settings = read.parameters.find("settings"); settings != read.parameters.end() && settings->contains("seed"))
    truth.world = settings->at("seed").dump();
  for (const TrueInterval& interval : read.intervals) {
    if (interval.labelled) {
      truth.true_ones.push_back(interval.interval);
      truth.gross.push_back(interval.gross);
    } else if (interval.first_event) {
      truth.unlabelled.push_back(interval.interval);
      truth.causes.push_back(cause_of(interval));
    }
  }
  return truth;
}

RunTruth with_truth_as_labels(const RunTruth& truth) {
  if (!truth.has_truth) throw Error("a run without truth.json; expected a simulated one");
  RunTruth exact = truth;
  exact.labels.clear();
  exact.visible.clear();
  exact.releases.clear();
  exact.unclear = truth.unlabelled;
  for (const TouchInterval& interval : truth.true_ones) exact.labels.push_back({interval, true});
  return exact;
}

RunTruth with_visible_onsets(RunTruth truth) {
  for (std::size_t i = 0; i < truth.visible.size(); ++i) {
    TouchInterval& label = truth.labels[i].interval;
    if (!truth.visible[i] || *truth.visible[i] >= label.end) continue;
    for (TouchInterval& touch : truth.true_ones) {
      const bool is_this = touch.touch == label.touch && touch.start < label.end && label.start < touch.end;
      if (is_this && *truth.visible[i] < touch.end) touch.start = std::max(*truth.visible[i], touch.start);
    }
    label.start = std::max(label.start, *truth.visible[i]);
  }
  return truth;
}

Touch touch_at(CameraTime tick, std::span<const TouchInterval> intervals) {
  const auto found =
      std::find_if(intervals.begin(), intervals.end(), [tick](const TouchInterval& interval) { return interval.contains(tick); });
  return found == intervals.end() ? Touch::none : found->touch;
}

}  // namespace tactile::evaluation
