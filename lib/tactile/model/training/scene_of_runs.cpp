#include "tactile/model/training/scene_of_runs.hpp"

#include <fmt/core.h>

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "tactile/core/error.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/events/recording_reader.hpp"

namespace tactile::model {
namespace {

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

}  // namespace

std::optional<characterise::SceneRanges> scene_of_runs(const windows::Dataset& dataset, std::span<const std::uint32_t> runs,
                                                       const events::MaskPixels& mask, unsigned threads) {
  const auto recordings = recordings_of(dataset, runs);
  if (!recordings) return std::nullopt;
  check_recordings(dataset, runs, *recordings, threads);
  std::vector<std::vector<characterise::Scene>> of_runs(runs.size());
  parallel_for(runs.size(), threads, [&](std::size_t i) {
    events::RecordingReader reader((*recordings)[i]);
    of_runs[i] = characterise::scenes_of(reader, mask);
  });
  characterise::SceneRanges scene;
  for (const std::vector<characterise::Scene>& of_run : of_runs) scene.add_run(of_run);
  return scene.runs > 0 ? std::optional(scene) : std::nullopt;
}

}  // namespace tactile::model
