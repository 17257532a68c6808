#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/evaluation/accuracy.hpp"
#include "tactile/model/definition/engine_kind.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile::study {

/// The confusion of one model on the balanced samples of one run.
struct NamedConfusion {
  std::string run;  ///< "fan/03"
  std::string object;
  results::Confusion confusion;
};

/// {"runs": [{"run", "object", "confusion"}]}, complete or not at all. @throws Error if it cannot be written
void write_confusions(const std::filesystem::path& file, std::span<const NamedConfusion> confusions);

/// @throws Error  if it cannot be read or has another form
std::vector<NamedConfusion> read_confusions(const std::filesystem::path& file);

/// Those of these runs, in their order. @throws Error  if one of them is missing
std::vector<results::RunConfusion> confusions_of_runs(std::span<const NamedConfusion> confusions,
                                                      std::span<const std::string> runs, std::size_t training);

/// What a model is judged on.
struct SampleJudgement {
  std::filesystem::path bundle;
  std::vector<std::uint32_t> runs;  ///< indexes into `Dataset::runs`
  model::EngineKind engine = model::EngineKind::fast;
  unsigned threads = 1;
};

/// The confusions of a model on the balanced samples of these runs, written to `file`.
/// @throws Error  as `model::open_classifier`; if heatmaps are missing, or the file cannot be written
void judge_samples(const windows::Dataset& dataset, const SampleJudgement& judgement, const std::filesystem::path& file,
                   const ProgressCallback& progress = {});

}  // namespace tactile::study
