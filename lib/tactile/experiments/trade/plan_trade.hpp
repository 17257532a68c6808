#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tactile/experiments/run_division.hpp"
#include "tactile/experiments/slurm.hpp"
#include "tactile/experiments/trade/experiment_design.hpp"
#include "tactile/experiments/trade/front_probability.hpp"
#include "tactile/experiments/trade/recommendation.hpp"
#include "tactile/experiments/trade/tick_times.hpp"
#include "tactile/experiments/trade/trade_figures.hpp"
#include "tactile/model/bundle/model_bundle.hpp"
#include "tactile/model/definition/model_settings.hpp"
#include "tactile/results/whole_runs.hpp"
#include "tactile/windows/dataset.hpp"

namespace tactile::trade {

/// What to measure of speed against accuracy.
struct TradeOptions {
  std::filesystem::path data = "data", models = "models", out = "trade";
  std::string train_run = "01";                   ///< of each object
  std::vector<std::string> choice_runs = {"02"};  ///< to choose settings on; results are reported on all others
  unsigned epochs = 10;                           ///< of each training of a LeNet, > 0
  unsigned steps = model::StreamOptions{}.steps;  ///< of each training of a stream, > 0
  unsigned trainings = 0;                         ///< of each setting that may be on a front; 0: 2 for tiny data, else 5
  std::uint64_t seed = 1;                         ///< of the first training; the next ones add 1, 2, …
  TradeSetting usual{};                           ///< the setting that one value at a time is changed in
  TradeLevels levels{};
  bool full = false;                       ///< measure every combination
  std::size_t corners = 6;                 ///< promising combinations of each front
  std::optional<double> budget_minutes{};  ///< of all that is done; what is not kept by then is left out
  TickTimesOptions timing{};
  std::chrono::milliseconds trial{20'000};  ///< how long the recommended setting runs in `detect`; 0: not
  TradeConstraints constraints{};
  std::filesystem::path program = "/proc/self/exe";  ///< trains
  std::optional<experiments::SlurmOptions> slurm{};  ///< trainings run on a cluster; nothing: on this machine
  unsigned threads = 0;                              ///< 0: as many as the machine has cores
};

/// The same options with trainings and threads filled in.
/// @throws Error  if the usual setting is impossible, or a history or tick is not positive
TradeOptions completed(TradeOptions options, const windows::Dataset& dataset);

/// A network, which several settings may share, of one training.
struct TradeNetwork {
  unsigned training = 0;  ///< from 0; it gives the run to learn from and the seed
  model::ModelSettings settings;
  model::ModelBundle bundle;

  std::string name() const { return bundle.name(); }
};

/// A setting, and what is measured of it.
struct TradePoint {
  TradeSetting setting;
  std::string design;                       ///< "usual", "one", "corner", "all"
  std::vector<TradeNetwork> networks = {};  ///< one for each training
  results::TradeResult choice = {}, reported = {};
  bool on_accuracy_front = false, on_delay_front = false;
  results::FrontProbability front_probability = {};
};

/// What one training learns from and is judged on. Each training has other runs: what one is judged on, another may learn from.
struct TradeTraining {
  std::string train_run;          ///< id of the run to learn from, of each object
  experiments::RunDivision runs;  ///< with the runs that the dataset has no samples of, except in `all_test`

  std::vector<std::uint32_t> tested() const;  ///< runs to choose on, then those to report on
};

/// The part of a point that costs time, with the network of its first training, which must exist.
TimedSetting timed_setting_of(const TradePoint& point);

/// What settings are measured on.
struct TradePlan {
  TradeOptions options;             ///< as `completed` returns them
  const windows::Dataset& dataset;  ///< must outlive the plan
  std::vector<TradeTraining> trainings = {};
  /// Every run that a training is tested on, by its index in the dataset. Indexes beyond those are of runs that the dataset has
  /// no samples of, such as those without a press or a slip.
  std::map<std::uint32_t, JudgedRun> judged = {};
  std::vector<results::LeftOutRun> left_out = {};  ///< runs of the same objects that cannot be judged

  std::vector<std::uint32_t> tested() const;  ///< all of them
  std::size_t objects() const;                ///< that they are of
  std::vector<RunFolder> folders(std::span<const std::uint32_t> runs) const;
  std::vector<std::string> names(std::span<const std::uint32_t> runs) const;
  nlohmann::json hashes(std::span<const std::uint32_t> runs) const;  ///< SHA-256 of their recordings
};

/// Why no setting can be confirmed, in a sentence: there are fewer than three objects, and fewer than three reported runs of one.
/// Empty if one can.
/// @param options  as `completed` returns them
std::string why_unconfirmable(const TradeOptions& options, const windows::Dataset& dataset);

/// First stage: divides the runs and reads the truth of those to test on.
/// @param options  as `completed` returns them
/// @throws Error  if there are no runs to choose on besides those to report on, or a recording differs from the dataset's
TradePlan plan_trade(const TradeOptions& options, const windows::Dataset& dataset);

/// The points of the design, the usual setting first: all others are compared with it.
std::vector<TradePoint> designed_points(const TradePlan& plan);

/// Adds settings that are not among the points yet.
void add_points(std::vector<TradePoint>& points, std::span<const TradeSetting> settings, const std::string& design);

/// The network that a setting needs. @param training  counted from 0
TradeNetwork network_of(const TradePlan& plan, const TradeSetting& setting, unsigned training);

/// The tick at which a network predicts whole runs for a setting of this tick: the longest one that this and the network's own
/// are multiples of.
microseconds prediction_tick(const TradeNetwork& network, microseconds tick);

/// A network by its differences from the usual one: "t_h 20 ms, int8", "the usual network"; with run and seed if there are
/// several.
std::string text_of(const TradePlan& plan, const TradeNetwork& network, microseconds tick, model::EngineKind engine,
                    model::Precision precision);

/// The same for the usual tick, engine and precision.
std::string text_of(const TradePlan& plan, const TradeNetwork& network);

}  // namespace tactile::trade
