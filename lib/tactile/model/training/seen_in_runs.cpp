#include "tactile/model/training/seen_in_runs.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "tactile/core/error.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/events/recording_reader.hpp"
#include "tactile/model/inference/background_ratio.hpp"
#include "tactile/model/training/train_model.hpp"
#include "tactile/windows/event_counts.hpp"

namespace tactile::model {
namespace {

/// The numbers of events in t_h at the presses and slips of a run.
std::vector<std::uint64_t> touch_counts(const windows::Dataset& dataset, std::uint32_t run,
                                        const heatmaps::HeatmapOptions& rendering) {
  std::vector<std::uint32_t> touches = samples_of_runs(dataset, {&run, 1});
  std::erase_if(touches, [&](std::uint32_t sample) { return dataset.samples()[sample].touch == Touch::none; });
  return windows::event_counts(dataset, run, touches, rendering.history, rendering.mask);
}

/// The recordings of these runs; nothing if one is missing.
std::optional<std::vector<std::filesystem::path>> recordings_of(const windows::Dataset& dataset,
                                                                std::span<const std::uint32_t> runs) {
  std::vector<std::filesystem::path> recordings;
  for (const std::uint32_t run : runs) {
    recordings.push_back(dataset.run_folder(run) / "events.aedat4");
    if (!std::filesystem::is_regular_file(recordings.back())) return std::nullopt;
  }
  return recordings;
}

/// @throws Error  if one differs from the recording that the dataset was made from
void check_recordings(const windows::Dataset& dataset, std::span<const std::uint32_t> runs,
                      const std::vector<std::filesystem::path>& recordings, unsigned threads) {
  std::vector<std::string> digests(runs.size());
  parallel_for(runs.size(), threads, [&](std::size_t i) { digests[i] = sha256_of_file(recordings[i]); });
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (digests[i] == dataset.runs()[runs[i]].events_sha256) continue;
    throw Error(
        fmt::format("{}: differs from the recording that {} was made from; expected the same, or run 'tactile windows' again",
                    recordings[i].string(), dataset.file().string()));
  }
}

std::vector<TouchInterval> labelled_in(const windows::Dataset& dataset, std::uint32_t run) {
  std::vector<TouchInterval> labelled;
  for (const windows::DatasetInterval& interval : dataset.intervals()) {
    if (interval.run_index == run) labelled.push_back(interval.interval);
  }
  return labelled;
}

}  // namespace

SeenInRuns seen_in(const windows::Dataset& dataset, std::span<const std::uint32_t> runs,
                   const heatmaps::HeatmapOptions& rendering, unsigned threads) {
  constexpr std::size_t most = 1000;
  struct SeenInRun {
    std::vector<std::uint64_t> counts;
    std::vector<double> ratios;
    std::vector<characterise::Scene> scenes;
  };
  std::vector<SeenInRun> of_runs(runs.size());
  const auto recordings = recordings_of(dataset, runs);
  if (recordings) check_recordings(dataset, runs, *recordings, threads);
  parallel_for(runs.size(), threads, [&](std::size_t i) {
    SeenInRun& of_run = of_runs[i];
    of_run.counts = touch_counts(dataset, runs[i], rendering);
    if (!recordings) return;
    events::RecordingReader reader((*recordings)[i]);
    of_run.ratios = opening_ratios(reader, labelled_in(dataset, runs[i]), rendering);
    of_run.scenes = characterise::scenes_of(reader, rendering.mask);
  });

  std::vector<std::uint64_t> counts;
  for (const SeenInRun& of_run : of_runs) counts.insert(counts.end(), of_run.counts.begin(), of_run.counts.end());
  SeenInRuns seen{.gate = calibrated_gate(counts), .scene = std::nullopt};
  if (!recordings) return seen;
  Gate& gate = seen.gate;
  characterise::SceneRanges scene;
  for (const SeenInRun& of_run : of_runs) {
    gate.ratios.insert(gate.ratios.end(), of_run.ratios.begin(), of_run.ratios.end());
    scene.add_run(of_run.scenes);
  }
  gate.intervals = gate.ratios.size();
  std::sort(gate.ratios.begin(), gate.ratios.end());
  gate.ratios.resize(std::min(gate.ratios.size(), most));
  if (scene.runs > 0) seen.scene = scene;  // else all are too short
  return seen;
}

Transitions transitions_of(const windows::Dataset& dataset, std::span<const std::uint32_t> runs) {
  Transitions transitions;
  for (const std::uint32_t run : runs) {
    const std::uint64_t count = dataset.runs()[run].events;
    if (count == 0) continue;
    std::vector<TouchInterval> labelled = labelled_in(dataset, run);
    std::sort(labelled.begin(), labelled.end(), [](const auto& a, const auto& b) { return a.start < b.start; });
    const auto time_of = [&](std::uint64_t event) { return dataset.events(run, event, 1).front().t; };
    transitions.add(time_of(0), time_of(count - 1), labelled);
  }
  return transitions;
}

}  // namespace tactile::model
