#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tactile/core/time.hpp"
#include "tactile/results/cost_growth.hpp"
#include "tactile/results/step_record.hpp"
#include "tactile/results/traded_setting.hpp"

namespace tactile::results {

/// A pair of history and tick that no setting has, because the history is no whole number of ticks.
struct UntriedPair {
  microseconds history{0}, tick{0};
  std::string why{};
};
void to_json(nlohmann::json& json, const UntriedPair& pair);
void from_json(const JsonView& json, UntriedPair& pair);

/// A setting that could not be measured, in words.
struct NotMeasured {
  std::string setting, why;
};
void to_json(nlohmann::json& json, const NotMeasured& one);
void from_json(const JsonView& json, NotMeasured& one);

/// The runs that one training learns from and is judged on: "fan/03".
struct TradeRuns {
  std::vector<std::string> train{}, choice{}, reported{};
};
void to_json(nlohmann::json& json, const TradeRuns& runs);
void from_json(const JsonView& json, TradeRuns& runs);

/// The dataset that settings were measured on.
struct TradeDataset {
  std::string file{};  ///< relative to the folder of the trade
  std::string manifest_hash{};
  nlohmann::json settings = nullptr;  ///< as its dataset.h5 has them
  std::uint64_t samples = 0;
};
void to_json(nlohmann::json& json, const TradeDataset& dataset);
void from_json(const JsonView& json, TradeDataset& dataset);

/// A setting that was measured again, by each of its networks, on the runs that this one reports on.
struct MeasuredAgain {
  TradeResult result{};
  std::string model{};  ///< of the first training
  std::uint64_t trainings = 0;
  std::vector<std::string> runs{};
};

/// The members of `TradeResult`, and {"model", "trainings", "runs"}
void to_json(nlohmann::json& json, const MeasuredAgain& again);
void from_json(const JsonView& json, MeasuredAgain& again);

/// The answer to constraints.
struct TradeRecommendation {
  nlohmann::json wish = nullptr;  ///< the constraints
  std::string id{};               ///< of a setting; empty if none meets the constraints on the runs to choose on
  std::optional<SettingValues> setting{};
  std::string model{};  ///< of its first training
  bool met = false;     ///< measured again, its intervals meet the constraints, and the trial meets the time
  std::optional<bool> chosen_in_interval{};
  std::optional<MeasuredAgain> again{};
  nlohmann::json trial = nullptr;  ///< as `detect --json` printed it; null if there was none
  std::string sentence{};
};

/// {"wish", "id", "setting", "model", "met", "chosen_in_interval", "again", "trial", "sentence"}; no "model" without a setting
void to_json(nlohmann::json& json, const TradeRecommendation& recommendation);
void from_json(const JsonView& json, TradeRecommendation& recommendation);

/// Speed against accuracy, as `tactile trade` measures it.
struct Trade {  // NOLINT(bugprone-exception-escape): moving nlohmann::json does not throw
  std::string title{};
  bool simulated = false;
  std::string times_are{};  ///< what a time per tick is, in sentences
  std::string judged_by{};  ///< which trainings judge which runs, in sentences
  nlohmann::json settings = nullptr, software = nullptr, machine = nullptr;
  BootstrapOptions bootstrap{};
  TradeDataset dataset{};
  std::vector<TradeRuns> runs{};        ///< of each training
  std::string usual{};                  ///< id of the usual setting
  std::string usual_is{};               ///< whether there is evidence for another one, in sentences
  double interrupted = 0;               ///< share of all timed ticks in which another program had the processor
  std::uint64_t busy = 0;               ///< settings whose `us_p99` is the machine's, not their own
  std::vector<TradedSetting> points{};  ///< the usual one first
  std::vector<UntriedPair> left_out{};
  std::vector<NotMeasured> not_measured{};
  std::string unfinished{};            ///< a sentence if the budget ended the work; else empty
  std::optional<CostGrowth> growth{};  ///< nothing if it was not measured
  TradeRecommendation recommendation{};
  std::vector<StepRecord> steps{};

  std::string cpu() const;  ///< that measured; empty if it is not known
};

inline constexpr std::string_view trade_format = "tactile-trade-1";

/// As trade.json has it; docs/format/ lists its keys.
void to_json(nlohmann::json& json, const Trade& trade);
void from_json(const JsonView& json, Trade& trade);  ///< @throws Error  if it is of another format

}  // namespace tactile::results
