#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tactile/core/progress.hpp"
#include "tactile/core/touch.hpp"
#include "tactile/evaluation/confirmation.hpp"
#include "tactile/model/inference/classifier.hpp"
#include "tactile/windows/dataset.hpp"
#include "tactile/windows/sample.hpp"

namespace tactile {

/// What a network says at every full tick of a run, before gate and confirmation.
struct RunSaid {
  std::string run;  ///< "fan/03"
  TickRange ticks;
  std::vector<Touch> said;            ///< one for each tick
  std::vector<std::uint64_t> events;  ///< in [t_c - t_h, t_c)
};

/// Renders every full tick of a recording by the classifier's settings, but at this tick, and classifies it.
/// @throws Error  as `classify_full_run`
RunSaid said_in_run(const std::filesystem::path& recording, const std::string& run, const Classifier& classifier,
                    microseconds tick);

/// Of several of the dataset's runs, in their order. @throws Error  as `classify_full_run`
std::vector<RunSaid> said_in_runs(const Dataset& dataset, std::span<const std::uint32_t> runs, const Classifier& classifier,
                                  microseconds tick, unsigned threads, const ProgressCallback& progress = {});

/// The same at a tick that is a whole number of the old ones: what `said_in_run` gives at it, since a heatmap depends on the
/// events of its history alone. @throws Error  if it is not
RunSaid at_tick(const RunSaid& said, microseconds tick);

/// The verdicts at each tick: none below the gate's limit, then confirmed.
std::vector<Touch> verdicts_of(const RunSaid& said, std::optional<std::uint64_t> gate, const Confirmation& confirmation);

/// {"runs": [{"run", "first_us", "tick_us", "said": "0012", "events": []}]}, whole or not at all.
void write_said(const std::filesystem::path& file, std::span<const RunSaid> runs);
std::vector<RunSaid> read_said(const std::filesystem::path& file);  ///< @throws Error  if it is no such file

}  // namespace tactile
