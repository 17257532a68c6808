#include "tactile/experiments/trade/plan_trade.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <set>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/evaluation/run_truth.hpp"
#include "tactile/experiments/models_folder.hpp"
#include "tactile/experiments/run_division.hpp"
#include "tactile/experiments/usual_trainings.hpp"
#include "tactile/model/training/train_model.hpp"

namespace tactile::trade {
namespace {

/// The longest tick that both are multiples of.
microseconds common_tick(microseconds a, microseconds b) { return microseconds{std::gcd(a.count(), b.count())}; }

JudgedRun judged_run(const windows::Dataset& dataset, std::uint32_t run) {
  const windows::DatasetRun& names = dataset.runs()[run];
  JudgedRun judged{.run = name_of(names), .object = names.object, .samples = {}, .truth = {}, .guard = dataset.sampling().guard};
  for (const std::uint32_t sample : model::samples_of_runs(dataset, {&run, 1}))
    judged.samples.push_back(dataset.samples()[sample]);
  judged.truth = evaluation::read_run_truth({dataset.run_folder(run), names.object, names.run},
                                            member<bool>(dataset.settings(), "include_flagged", dataset.file().string()));
  return judged;
}

}  // namespace

TradeOptions completed(TradeOptions options, const windows::Dataset& dataset) {
  if (options.trainings == 0) options.trainings = experiments::usual_trainings(dataset);
  if (const auto why = why_impossible(options.usual)) throw Error("the usual setting is impossible: " + *why);
  for (const auto* times : {&options.levels.histories, &options.levels.ticks}) {
    for (const microseconds time : *times) {
      if (time <= microseconds{0}) throw Error("a history or a tick of 0 us; expected more");
    }
  }
  options.threads = threads_or_all(options.threads);
  return options;
}

std::string why_unconfirmable(const TradeOptions& options, const windows::Dataset& dataset) {
  std::map<std::string, std::set<std::uint32_t>> reported;
  for (unsigned training = 0; training < options.trainings; ++training) {
    const auto runs = experiments::rotated_division(dataset, options.train_run, options.choice_runs, training);
    for (const std::uint32_t run : runs.reported) reported[dataset.runs()[run].object].insert(run);
  }
  std::size_t fewest = std::numeric_limits<std::size_t>::max();
  for (const auto& object : reported) fewest = std::min(fewest, object.second.size());
  if (reported.size() >= fewest_objects || reported.empty() || fewest >= fewest_runs) return {};
  return fmt::format(
      "no setting can be confirmed: {} object{} and {} reported run{} of one give no 95 % interval; expected {} objects, or {} "
      "reported runs of each: more runs, or more --trainings",
      reported.size(), reported.size() == 1 ? "" : "s", fewest, fewest == 1 ? "" : "s", fewest_objects, fewest_runs);
}

TradePlan plan_trade(const TradeOptions& options, const windows::Dataset& dataset) {
  TradePlan plan{.options = options, .dataset = dataset};
  for (unsigned training = 0; training < options.trainings; ++training) {
    plan.trainings.push_back({experiments::rotated_run(dataset, options.train_run, training),
                              experiments::rotated_division(dataset, options.train_run, options.choice_runs, training)});
    if (plan.trainings.back().runs.choice.empty()) {
      throw Error(
          fmt::format("{}: no runs ({}) to choose settings on besides others to report on; expected three runs of an object at "
                      "least, or other --choice-runs",
                      dataset.file().string(), fmt::join(options.choice_runs, ", ")));
    }
    for (const std::uint32_t run : plan.trainings.back().tested()) {
      if (plan.judged.contains(run)) continue;
      windows::check_unchanged(dataset, run);
      plan.judged.emplace(run, judged_run(dataset, run));
    }
  }
  return plan;
}

std::vector<TradePoint> designed_points(const TradePlan& plan) {
  const TradeOptions& options = plan.options;
  std::vector<TradePoint> points;
  add_points(points, {&options.usual, 1}, "usual");
  add_points(points,
             options.full ? all_combinations(options.usual, options.levels) : one_at_a_time(options.usual, options.levels),
             options.full ? "all" : "one");
  return points;
}

void add_points(std::vector<TradePoint>& points, std::span<const TradeSetting> settings, const std::string& design) {
  for (const TradeSetting& setting : settings) {
    const auto is_same = [&](const TradePoint& point) { return point.setting == setting; };
    if (std::none_of(points.begin(), points.end(), is_same)) points.push_back({.setting = setting, .design = design});
  }
}

TradeNetwork network_of(const TradePlan& plan, const TradeSetting& setting, unsigned training) {
  TradeNetwork network{.training = training, .settings = {}, .bundle = {}};
  network.settings.rendering = setting.rendering;
  // A network sees heatmaps, not ticks: it is trained at the dataset's tick, or at one that fits its history too.
  network.settings.rendering.tick = common_tick(plan.dataset.sampling().tick, setting.rendering.history);
  network.settings.kind = setting.kind;
  network.settings.network.width = setting.width;
  network.settings.network.last_pool = setting.last_pool;
  network.settings.training.augmentation = setting.augmentation;
  network.settings.training.seed = plan.options.seed + training;
  network.settings.training.epochs = plan.options.epochs;
  network.settings.split.train_run = plan.trainings[training].train_run;
  network.bundle =
      experiments::training_bundle(plan.options.models, plan.options.out, network.settings, plan.dataset.manifest_hash());
  return network;
}

microseconds prediction_tick(const TradeNetwork& network, microseconds tick) {
  return common_tick(network.settings.rendering.tick, tick);
}

std::string text_of(const TradePlan& plan, const TradeNetwork& network, microseconds tick, model::EngineKind engine,
                    model::Precision precision) {
  TradeSetting setting = plan.options.usual, usual = plan.options.usual;
  setting.kind = network.settings.kind;
  setting.rendering = network.settings.rendering;
  setting.width = network.settings.network.width;
  setting.last_pool = network.settings.network.last_pool;
  setting.augmentation = network.settings.training.augmentation;
  setting.rendering.tick = tick;
  setting.engine = engine;
  setting.precision = precision;
  usual.rendering.tick = prediction_tick(network_of(plan, usual, 0), usual.rendering.tick);
  std::string text = setting == usual ? "the usual network" : text_of(setting, usual);
  if (plan.options.trainings == 1) return text;
  return fmt::format("{}, run {}, seed {}", text, network.settings.split.train_run, network.settings.training.seed);
}

std::string text_of(const TradePlan& plan, const TradeNetwork& network) {
  const TradeSetting& usual = plan.options.usual;
  return text_of(plan, network, prediction_tick(network_of(plan, usual, 0), usual.rendering.tick), usual.engine, usual.precision);
}

std::vector<std::uint32_t> TradeTraining::tested() const {
  std::vector<std::uint32_t> indexes = runs.choice;
  indexes.insert(indexes.end(), runs.reported.begin(), runs.reported.end());
  return indexes;
}

std::vector<std::uint32_t> TradePlan::tested() const {
  std::vector<std::uint32_t> indexes;
  for (const auto& one : judged) indexes.push_back(one.first);
  return indexes;
}

std::size_t TradePlan::objects() const {
  std::set<std::string> names;
  for (const auto& one : judged) names.insert(one.second.object);
  return names.size();
}

TimedSetting timed_setting_of(const TradePoint& point) {
  const TradeSetting& setting = point.setting;
  return {setting.rendering, setting.engine, setting.precision, setting.sparse, point.networks.front().bundle.folder};
}

std::optional<model::GateRule> gate_of(const TradeSetting& setting, const TradeNetwork& network) {
  if (!setting.gate) return std::nullopt;
  return model::gate_rule(network.bundle, model::read_description(network.bundle));
}

}  // namespace tactile::trade
