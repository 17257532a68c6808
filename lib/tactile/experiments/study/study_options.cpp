#include "tactile/experiments/study/study_options.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "tactile/core/error.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/heatmaps/heatmap_renderer.hpp"

namespace tactile::study {

PresetSettings preset_settings(std::string_view preset) {
  if (preset == "tiny") return {1, 2, 2, 3, 100};
  if (preset == "quick") return {3, 1, 5, 6, 800};
  if (preset == "paper") return {8, 1, 5, 10, 1600};
  throw Error(fmt::format("'{}' is no preset; expected tiny, quick or paper", preset));
}

StudyOptions completed(StudyOptions options, bool has_own_runs) {
  const PresetSettings preset = preset_settings(options.preset);
  if (has_own_runs && options.worlds) {
    throw Error(fmt::format(
        "{}: holds runs already, and they are one world; expected no --worlds, which are simulated, or another folder",
        options.data.string()));
  }
  options.worlds = has_own_runs ? 1 : options.worlds.value_or(preset.worlds);
  options.trainings = options.trainings.value_or(has_own_runs ? preset.trainings_of_own_runs : preset.trainings);
  options.epochs = options.epochs.value_or(preset.epochs);
  options.steps = options.steps.value_or(preset.steps);
  if (*options.worlds == 0) throw Error("no world; expected one at least");
  if (*options.trainings == 0) throw Error("no training of a setting; expected one at least");
  options.threads = threads_or_all(options.threads);
  std::sort(options.histories.begin(), options.histories.end());
  options.histories.erase(std::unique(options.histories.begin(), options.histories.end()), options.histories.end());
  if (options.histories.empty()) throw Error("no history to train for; expected one at least");
  for (const microseconds history : options.histories) check(heatmaps::HeatmapOptions{.history = history});
  return options;
}

std::vector<World> worlds_of(const StudyOptions& options) {
  if (*options.worlds == 1) return {{"", options.seed, options.data}};
  std::vector<World> worlds;
  for (unsigned i = 0; i < *options.worlds; ++i) {
    const std::uint64_t seed = options.seed + std::uint64_t{i} * *options.trainings;
    worlds.push_back({std::to_string(seed), seed, options.data / fmt::format("world-{}", seed)});
  }
  return worlds;
}

microseconds main_history(const StudyOptions& options) {
  constexpr microseconds of_paper{40'000};
  return *std::min_element(options.histories.begin(), options.histories.end(), [&](microseconds a, microseconds b) {
    return std::chrono::abs(a - of_paper) < std::chrono::abs(b - of_paper);
  });
}

}  // namespace tactile::study
