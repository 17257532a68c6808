#pragma once

#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "tactile/core/progress.hpp"
#include "tactile/experiments/trade/recommendation.hpp"
#include "tactile/experiments/trade/trade_setting.hpp"

namespace tactile::trade {

struct LiveTrialOptions {
  std::filesystem::path program;  ///< has the commands `serve` and `detect`
  std::filesystem::path run;      ///< to play, again and again
  std::filesystem::path model;    ///< the bundle
  std::filesystem::path folder;   ///< of logs; made if it is missing
  std::chrono::milliseconds length{20'000};
};

/// Runs a setting in `tactile detect` on a run that `tactile serve` plays in real time on a free port of 127.0.0.1. Both are
/// processes that end with this call, however it ends.
/// @param progress  called some times a second; an exception from it ends the trial
/// @return  what `detect --json` prints
/// @throws Error  with the last line of its log, if a process fails or does not end
nlohmann::json run_live_trial(const TradeSetting& setting, const LiveTrialOptions& options,
                              const ProgressCallback& progress = {});

/// @param detected  what `detect --json` printed   @throws Error  if figures are missing
LiveTrial live_trial_in(const nlohmann::json& detected);

/// The options of `detect` for a setting, except for the source. The model's path stays as it is.
nlohmann::json detect_options(const TradeSetting& setting, const std::filesystem::path& model);

}  // namespace tactile::trade
