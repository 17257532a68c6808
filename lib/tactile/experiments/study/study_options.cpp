#include "tactile/experiments/study/study_options.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "tactile/core/error.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/heatmaps/heatmap_renderer.hpp"

namespace tactile::study {

PresetSettings preset_settings(std::string_view preset) {
  if (preset == "tiny") return {0, 3, 2, 0};
  if (preset == "quick") return {1, 6, 5, 0};
  if (preset == "paper") return {2, 10, 5, 20};
  throw Error(fmt::format("'{}' is no preset; expected tiny, quick or paper", preset));
}

StudyOptions completed(StudyOptions options) {
  const PresetSettings preset = preset_settings(options.preset);
  options.epochs = options.epochs.value_or(preset.epochs);
  options.trainings = options.trainings.value_or(preset.trainings);
  options.splits = options.splits.value_or(preset.splits);
  if (*options.trainings == 0) throw Error("no training of a setting; expected one at least");
  options.threads = threads_or_all(options.threads);
  std::sort(options.histories.begin(), options.histories.end());
  options.histories.erase(std::unique(options.histories.begin(), options.histories.end()), options.histories.end());
  if (options.histories.empty()) throw Error("no history to train for; expected one at least");
  for (const microseconds history : options.histories) check(heatmaps::HeatmapOptions{.history = history});
  return options;
}

}  // namespace tactile::study
