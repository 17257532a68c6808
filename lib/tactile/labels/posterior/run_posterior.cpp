#include "tactile/labels/posterior/run_posterior.hpp"

#include <memory>

#include "tactile/core/parallel.hpp"
#include "tactile/labels/posterior/run_inference.hpp"
#include "tactile/labels/posterior/session_offsets.hpp"

namespace tactile::labels {
namespace {

OffsetsOfRun offsets_of(const ClockOffsets& clock) {
  if (!clock.course() || clock.course()->is_of_film()) return {};
  OffsetsOfRun run{.at = clock.course()->begin() + (clock.course()->end() - clock.course()->begin()) / 2,
                   .offsets = clock.likely()};
  normalise(run.offsets);
  return run;
}

}  // namespace

RunPosterior run_posterior(const alignment::RunSignals& signals) { return RunInference(signals).posterior({}); }

std::vector<RunPosterior> session_posteriors(std::span<const alignment::RunSignals* const> runs, unsigned threads) {
  std::vector<std::unique_ptr<RunInference>> inferences(runs.size());
  std::vector<OffsetsOfRun> alone(runs.size());
  parallel_for(runs.size(), threads, [&](std::size_t i) {
    inferences[i] = std::make_unique<RunInference>(*runs[i]);
    alone[i] = offsets_of(inferences[i]->clock());
  });
  const std::vector<std::vector<WeighedOffset>> others = offsets_by_others(alone);
  std::vector<RunPosterior> posteriors(runs.size());
  parallel_for(runs.size(), threads, [&](std::size_t i) {
    posteriors[i] = inferences[i]->posterior(others[i]);
    inferences[i].reset();
  });
  return posteriors;
}

}  // namespace tactile::labels
