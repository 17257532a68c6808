#include "tactile/experiments/trade/full_runs.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <mutex>

#include "tactile/core/error.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/experiments/file_step.hpp"

namespace tactile::trade {

std::vector<results::FullRun> classify_full_runs(std::span<const RunFolder> runs, const model::Classifier& classifier,
                                                 const evaluation::FullRunOptions& options, const ProgressCallback& progress) {
  std::vector<results::FullRun> classified(runs.size());
  std::mutex one_at_a_time;
  std::size_t done = 0;
  parallel_for(runs.size(), options.threads, [&](std::size_t i) {
    classified[i] = evaluation::classify_full_run(runs[i].events(), classifier, {.tick = options.tick});
    classified[i].run = runs[i].name();
    const std::scoped_lock lock(one_at_a_time);
    report_progress(progress, ++done, runs.size(), fmt::format("predicting every tick: {} of {} runs", done, runs.size()));
  });
  return classified;
}

results::FullRun at_tick(const results::FullRun& run, microseconds tick) {
  if (tick <= microseconds{0} || tick % run.ticks.tick != microseconds{0}) {
    throw Error(
        fmt::format("ticks of {} us of a run predicted every {} us; expected a multiple", tick.count(), run.ticks.tick.count()));
  }
  if (tick == run.ticks.tick) return run;
  results::FullRun fewer{.run = run.run, .ticks = {.first = {}, .count = 0, .tick = tick}};
  for (std::int64_t i = 0; i < run.ticks.count; ++i) {
    const CameraTime t = run.ticks.at(i);
    if (us_of(t) % tick.count() != 0) continue;
    if (fewer.ticks.count++ == 0) fewer.ticks.first = t;
    fewer.verdicts.push_back(run.verdicts[static_cast<std::size_t>(i)]);
    fewer.events.push_back(run.events[static_cast<std::size_t>(i)]);
    if (!run.probabilities.empty()) fewer.probabilities.push_back(run.probabilities[static_cast<std::size_t>(i)]);
  }
  return fewer;
}

void write_full_runs(const std::filesystem::path& file, std::span<const results::FullRun> runs) {
  nlohmann::json list = nlohmann::json::array();
  for (const results::FullRun& run : runs) list.push_back(run);
  write_whole(file, nlohmann::json{{"runs", list}}.dump() + "\n");
}

std::vector<results::FullRun> read_full_runs(const std::filesystem::path& file) {
  const auto json = nlohmann::json::parse(read_text(file, experiments::largest_step_file), nullptr, false);
  if (json.is_discarded()) throw Error(file.string() + ": no JSON; expected predictions of runs");
  return results::JsonView(json, file.string(), results::MissingMember::is_error)["runs"].list_of<results::FullRun>();
}

}  // namespace tactile::trade
