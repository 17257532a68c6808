#include "tactile/labels/posterior/run_posterior.hpp"

#include <algorithm>
#include <memory>

#include "tactile/core/error.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/labels/posterior/run_inference.hpp"
#include "tactile/labels/posterior/session_offsets.hpp"

namespace tactile::labels {
namespace {

PlaceCounts counts_in(const alignment::RunSignals& signals) {
  constexpr microseconds bin = 1000us, longest_run = 30s;
  events::RecordingReader recording(signals.run.events());
  PlaceCounts counts = place_counts(recording, signals.event_stream, signals.rate, signals.gaps, bin);
  counts.several_runs = between(signals.rate.begin, signals.rate.last) > longest_run;
  return counts;
}

}  // namespace

RunPosterior run_posterior(const alignment::RunSignals& signals) {
  return RunInference(signals, counts_in(signals)).posterior({});
}

std::vector<RunPosterior> session_posteriors(std::span<const alignment::RunSignals* const> runs, unsigned threads) {
  std::vector<std::unique_ptr<RunInference>> inferences(runs.size());
  std::vector<OffsetsOfRun> alone(runs.size());
  std::vector<RunPosterior> posteriors(runs.size());
  parallel_for(runs.size(), threads, [&](std::size_t i) {
    try {
      inferences[i] = std::make_unique<RunInference>(*runs[i], counts_in(*runs[i]));
      alone[i] = inferences[i]->robot_offsets();
    } catch (const Error&) {
      posteriors[i].failure = std::current_exception();
    }
  });
  const std::vector<std::vector<WeighedOffset>> others = offsets_by_others(alone);
  const auto runs_with_clock = static_cast<std::size_t>(
      std::count_if(alone.begin(), alone.end(), [](const OffsetsOfRun& run) { return !run.offsets.empty(); }));
  parallel_for(runs.size(), threads, [&](std::size_t i) {
    if (!inferences[i]) return;
    posteriors[i] = inferences[i]->posterior(others[i]);
    if (!others[i].empty()) posteriors[i].runs_of_robot = runs_with_clock + (alone[i].offsets.empty() ? 1 : 0);
    inferences[i].reset();
  });
  return posteriors;
}

}  // namespace tactile::labels
