#include "tactile/evaluation/scene_remarks.hpp"

#include <fmt/core.h>

#include "tactile/core/parallel.hpp"
#include "tactile/events/recording_reader.hpp"

namespace tactile::evaluation {

std::string scene_remark(const model::ModelDescription& model, std::span<const WatchedRun> runs, unsigned threads) {
  constexpr std::size_t most_named = 3;
  if (!model.scene) return {};
  std::vector<std::string> departures(runs.size());
  parallel_for(runs.size(), threads, [&](std::size_t i) {
    events::RecordingReader reader(runs[i].recording);
    departures[i] = characterise::departures(characterise::scenes_of(reader, model.settings.rendering.mask), *model.scene);
  });
  std::size_t outside = 0;
  std::string named;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (departures[i].empty()) continue;
    if (outside++ < most_named) named += fmt::format("{}{} ({})", named.empty() ? "" : ", ", runs[i].name, departures[i]);
  }
  if (outside == 0) return {};
  if (outside > most_named) named += ", ...";
  return fmt::format("scene: {} of {} judged {} the training runs: {}", outside, runs.size(),
                     runs.size() == 1 ? "run leaves" : "runs leave", named);
}

}  // namespace tactile::evaluation
