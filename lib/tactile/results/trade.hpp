#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tactile/core/time.hpp"
#include "tactile/results/members.hpp"
#include "tactile/results/step_record.hpp"
#include "tactile/results/traded_setting.hpp"

namespace tactile::results {

/// A pair of history and tick that no setting has, because the history is no whole number of ticks.
struct UntriedPair {
  microseconds history{0}, tick{0};
  std::string why{};
};

template <class Members>
void list_members(Members& members, UntriedPair& pair) {
  members("th_ms", pair.history);
  members("tick_ms", pair.tick);
  members("why", pair.why);
}

/// A setting that could not be measured, in words.
struct NotMeasured {
  std::string setting{}, why{};
};

template <class Members>
void list_members(Members& members, NotMeasured& one) {
  members("setting", one.setting);
  members("why", one.why);
}

/// The runs that one training learns from and is judged on: "fan/03".
struct TradeRuns {
  std::vector<std::string> train{}, choice{}, reported{};
};

template <class Members>
void list_members(Members& members, TradeRuns& runs) {
  members("train", runs.train);
  members("choice", runs.choice);
  members("reported", runs.reported);
}

/// The dataset that settings were measured on.
struct TradeDataset {
  std::string file{};  ///< relative to the folder of the trade
  std::string manifest_hash{};
  nlohmann::json settings = nullptr;  ///< as its dataset.h5 has them
  std::uint64_t samples = 0;
};

template <class Members>
void list_members(Members& members, TradeDataset& dataset) {
  members("file", dataset.file);
  members("manifest_hash", dataset.manifest_hash);
  members("settings", dataset.settings);
  members("samples", dataset.samples);
}

/// The answer to constraints.
struct TradeRecommendation {
  nlohmann::json wish = nullptr;  ///< the constraints
  std::string id{};               ///< of a setting; empty if none meets the constraints on the runs to choose on
  std::optional<SettingValues> setting{};
  std::string model{};  ///< of its first training; empty without a setting
  bool met = false;     ///< its intervals meet the constraints on the reported runs too, and the trial meets the time
  std::optional<bool> chosen_in_interval{};
  nlohmann::json trial = nullptr;  ///< as `detect --json` printed it; null if there was none
  std::string sentence{};
};

template <class Members>
void list_members(Members& members, TradeRecommendation& recommendation) {
  members("wish", recommendation.wish);
  members("id", recommendation.id);
  members("setting", recommendation.setting);
  members("model", recommendation.model);
  members("met", recommendation.met);
  members("chosen_in_interval", recommendation.chosen_in_interval);
  members("trial", recommendation.trial);
  members("sentence", recommendation.sentence);
}

/// Speed against accuracy, as `tactile trade` measures it.
struct Trade {  // NOLINT(bugprone-exception-escape): moving nlohmann::json does not throw
  static constexpr const char* command = "tactile trade";

  std::string format = "tactile-trade-2";
  std::string title{};
  bool simulated = false;
  std::string times_are{};  ///< what a time per tick is, in sentences
  std::string judged_by{};  ///< which trainings judge which runs, in sentences
  nlohmann::json settings = nullptr, software = nullptr, machine = nullptr;
  BootstrapOptions bootstrap{};
  TradeDataset dataset{};
  std::vector<TradeRuns> runs{};        ///< of each training
  std::string usual{};                  ///< id of the usual setting
  double interrupted = 0;               ///< share of all timed ticks in which another program had the processor
  std::uint64_t busy = 0;               ///< settings whose `us_p99` is the machine's, not their own
  std::vector<TradedSetting> points{};  ///< the usual one first
  std::vector<UntriedPair> left_out{};
  std::vector<NotMeasured> not_measured{};
  std::string unfinished{};  ///< a sentence if the budget ended the work; else empty
  TradeRecommendation recommendation{};
  std::vector<StepRecord> steps{};

  std::string cpu() const;  ///< that measured; empty if it is not known
};

template <class Members>
void list_members(Members& members, Trade& trade) {
  members("format", trade.format);
  members("title", trade.title);
  members("simulated", trade.simulated);
  members("times_are", trade.times_are);
  members("judged_by", trade.judged_by);
  members("settings", trade.settings);
  members("software", trade.software);
  members("machine", trade.machine);
  members("bootstrap", trade.bootstrap);
  members("dataset", trade.dataset);
  members("runs", trade.runs);
  members("usual", trade.usual);
  members("interrupted", trade.interrupted);
  members("busy", trade.busy);
  members("points", trade.points);
  members("left_out", trade.left_out);
  members("not_measured", trade.not_measured);
  members("unfinished", trade.unfinished);
  members("recommendation", trade.recommendation);
  members("steps", trade.steps);
}

}  // namespace tactile::results
