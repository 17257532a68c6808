#include "tactile/experiments/trade/plan_trade.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <set>

#include "tactile/core/error.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/evaluation/other_runs.hpp"
#include "tactile/evaluation/run_figures.hpp"
#include "tactile/evaluation/run_result.hpp"
#include "tactile/evaluation/run_truth.hpp"
#include "tactile/experiments/models_folder.hpp"
#include "tactile/experiments/run_division.hpp"
#include "tactile/experiments/usual_trainings.hpp"

namespace tactile::trade {
namespace {

/// The longest tick that both are multiples of.
microseconds common_tick(microseconds a, microseconds b) { return microseconds{std::gcd(a.count(), b.count())}; }

JudgedRun judged_run(const windows::Dataset& dataset, const RunFolder& folder) {
  return {.folder = folder,
          .events_sha256 = {},
          .samples = {},
          .truth = evaluation::read_run_truth(folder, evaluation::includes_flagged(dataset))};
}

/// Gives each training the runs that the dataset has no samples of: to choose on where they have an id of its choice runs, else
/// to report on.
void add_other_runs(TradePlan& plan) {
  const std::vector<std::uint32_t> sampled = plan.tested();
  evaluation::OtherRuns others = evaluation::other_runs(plan.dataset, sampled, windows::SplitOptions{});
  plan.left_out = std::move(others.left_out);
  auto index = static_cast<std::uint32_t>(plan.dataset.runs().size());
  for (const RunFolder& folder : others.runs) {
    plan.judged.emplace(index, judged_run(plan.dataset, folder)).first->second.events_sha256 = sha256_of_file(folder.events());
    for (std::size_t training = 0; training < plan.trainings.size(); ++training) {
      const std::vector<std::string>& choice = plan.options.choice_runs;
      const bool is_choice = std::any_of(choice.begin(), choice.end(), [&](const std::string& run) {
        return experiments::rotated_run(plan.dataset, run, training) == folder.run;
      });
      experiments::RunDivision& runs = plan.trainings[training].runs;
      (is_choice ? runs.choice : runs.reported).push_back(index);
    }
    ++index;
  }
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
  if (reported.size() >= evaluation::fewest_objects || reported.empty() || fewest >= evaluation::fewest_objects) return {};
  return fmt::format(
      "no setting can be confirmed: {} object{} and {} reported run{} of one give no 95 % interval; expected {} objects, or {} "
      "reported runs of each: more runs, or more --trainings",
      reported.size(), reported.size() == 1 ? "" : "s", fewest, fewest == 1 ? "" : "s", evaluation::fewest_objects,
      evaluation::fewest_objects);
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
      JudgedRun judged = judged_run(dataset, evaluation::folder_of(dataset, run));
      judged.events_sha256 = dataset.runs()[run].events_sha256;
      judged.samples = evaluation::samples_in(dataset, run);
      plan.judged.emplace(run, std::move(judged));
    }
  }
  add_other_runs(plan);
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
  // LeNet sees heatmaps, not ticks: it is trained at the dataset's tick, or at one that fits its history too.
  if (reads_heatmaps(setting.kind))
    network.settings.rendering.tick = common_tick(plan.dataset.sampling().tick, setting.rendering.history);
  network.settings.kind = setting.kind;
  network.settings.training.augmentation = setting.augmentation;
  network.settings.training.seed = plan.options.seed + training;
  network.settings.training.epochs = plan.options.epochs;
  network.settings.stream.steps = plan.options.steps;
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
  for (const auto& one : judged) names.insert(one.second.folder.object);
  return names.size();
}

std::vector<RunFolder> TradePlan::folders(std::span<const std::uint32_t> runs) const {
  std::vector<RunFolder> folders;
  for (const std::uint32_t run : runs) folders.push_back(judged.at(run).folder);
  return folders;
}

nlohmann::json TradePlan::hashes(std::span<const std::uint32_t> runs) const {
  nlohmann::json hashes = nlohmann::json::array();
  for (const std::uint32_t run : runs) hashes.push_back(judged.at(run).events_sha256);
  return hashes;
}

std::vector<std::string> TradePlan::names(std::span<const std::uint32_t> runs) const {
  std::vector<std::string> names;
  for (const std::uint32_t run : runs) names.push_back(judged.at(run).folder.name());
  return names;
}

TimedSetting timed_setting_of(const TradePoint& point) {
  const TradeSetting& setting = point.setting;
  return {setting.rendering, setting.engine, setting.precision, point.networks.front().bundle.folder};
}

}  // namespace tactile::trade
