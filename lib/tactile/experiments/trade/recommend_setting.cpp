#include "tactile/experiments/trade/recommend_setting.hpp"

#include <fmt/core.h>

#include "tactile/core/json.hpp"
#include "tactile/core/machine.hpp"
#include "tactile/core/version.hpp"
#include "tactile/evaluation/evaluation.hpp"
#include "tactile/experiments/file_step.hpp"
#include "tactile/experiments/milliseconds.hpp"
#include "tactile/experiments/run_division.hpp"
#include "tactile/experiments/trade/full_runs.hpp"
#include "tactile/experiments/trade/recommendation.hpp"
#include "tactile/model/training/open_classifier.hpp"

namespace tactile::trade {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::optional<TradeChoice> choose_point(const TradeConstraints& constraints, std::span<const TradePoint> points) {
  if (!constraints.any()) return std::nullopt;
  std::vector<TradeFigures> candidates;
  for (const TradePoint& point : points) {
    candidates.push_back(point.choice.figures);
    if (!point.setting.sparse) candidates.back().accuracy = {};  // `detect` has no dense pass: it is measured for comparison only
  }
  return choose(constraints, candidates);
}

/// History, tick and factor, and all other differences from the defaults.
std::string whole_text(const TradeSetting& setting) {
  TradeSetting named;
  named.rendering.history = setting.rendering.history;
  named.rendering.tick = setting.rendering.tick;
  named.rendering.factor = setting.rendering.factor;
  return fmt::format("t_h {:g} ms, tick {:g} ms, factor {:g}{}", in_ms(setting.rendering.history), in_ms(setting.rendering.tick),
                     setting.rendering.factor, setting == named ? "" : ", " + text_of(setting, named));
}

/// Measures a setting on the reported runs, by the network of its first seed. Uses nothing that was measured before. Times are
/// taken in turns with those of the usual setting. If the tick is the network's own, `evaluate` gives accuracy and false alarms.
/// @return  `TradeResult` as JSON, with "by" ("eval" or "trade"), "model" and "runs"
json measure_again(const TradePlan& plan, const TradePoint& point, const TradePoint& usual, const TestedRuns& runs,
                   const ProgressCallback& progress) {
  const TradeSetting& setting = point.setting;
  const TradeNetwork& network = point.networks.front();
  const unsigned threads = plan.options.threads;
  const auto gate = gate_of(setting, network);
  const std::vector<TimedSetting> timed{timed_setting_of(usual), timed_setting_of(point)};
  const auto times = time_ticks(timed, runs.recordings, plan.options.timing, progress);
  const auto open_network = [&](unsigned network_threads) {
    return model::open_classifier(network.bundle.folder, network_threads, setting.engine, {.precision = setting.precision});
  };
  const std::vector<results::FullRun> predicted =
      classify_full_runs(plan.dataset, runs.indexes, open_network(1), setting.rendering.tick, threads, progress);
  std::vector<TradedRun> outcomes;
  for (std::size_t i = 0; i < runs.indexes.size(); ++i) {
    outcomes.push_back(outcome_of(runs.judged[i], predicted[i], verdicts_of(predicted[i], gate, setting.confirmation)));
    add_times(outcomes.back(), times[1].at(i), gate);
  }
  json result = result_of(outcomes);
  result["by"] = "trade";
  // `eval` judges only at the network's own ticks, where samples lie.
  if (setting.rendering.tick == network.settings.rendering.tick) {
    const results::Evaluation evaluation =
        evaluation::evaluate(plan.dataset, open_network(threads), runs.indexes,
                             {.confirmation = setting.confirmation, .gate = setting.gate, .threads = threads}, progress);
    result["by"] = "eval";
    result["accuracy"] = evaluation.accuracy.mean;
    result["false_alarms_per_min"] = evaluation.network.false_alarms.per_min;
  }
  result["model"] = network.name();
  result["runs"] = names_of(plan.dataset, runs.indexes);
  return result;
}

/// The same as a step.
json run_again(const TradePlan& plan, const TradePoint& point, const TradePoint& usual, experiments::StepRunner& runner) {
  const std::string id = id_of(point.setting);
  const fs::path file = plan.options.out / "again" / (id + ".json");
  const TestedRuns reported = plan.tested.from(plan.choice_count);
  runner.run(experiments::file_step(
      "again-" + id,
      {{"manifest", plan.dataset.manifest_hash()},
       {"weights", model::read_description(point.networks.front().bundle).weights_sha256},
       {"setting", point.setting},
       {"runs", names_of(plan.dataset, reported.indexes)},
       {"truth", experiments::truth_hashes(plan.dataset, reported.indexes)},
       {"machine", cpu_name()},
       {"revision", revision()}},
      file, [&](const ProgressCallback& progress) { write_json(file, measure_again(plan, point, usual, reported, progress)); },
      fmt::format("measuring the chosen setting again, on {} runs that it was not chosen on: {}", reported.indexes.size(),
                  text_of(point.setting, plan.options.usual))));
  return read_json(file);
}

TradeFigures figures_in(const json& again, const fs::path& folder, double tick_us) {
  const results::JsonView view(again, folder.string(), results::MissingMember::is_error);
  return {.accuracy = view["accuracy"].get<results::Figure>(),
          .us_p99 = view["us"]["p99"].get<results::Figure>(),
          .us_p50 = view["us"]["p50"].get<results::Figure>(),
          .delay_us = view["delay_us"]["mean"].get<results::Figure>(),
          .false_alarms_per_min = view["false_alarms_per_min"].get<results::Figure>(),
          .tick_us = tick_us};
}

}  // namespace

json recommend_setting(const TradePlan& plan, std::span<const TradePoint> points, experiments::StepRunner& runner) {
  const TradeConstraints& constraints = plan.options.constraints;
  json result = {{"wish", constraints},           {"setting", nullptr}, {"id", nullptr}, {"met", false},
                 {"chosen_in_interval", nullptr}, {"again", nullptr}};
  Recommendation recommendation;
  if (const auto choice = choose_point(constraints, points)) {
    const TradePoint &point = points[choice->index], &usual = points.front();
    const json again = run_again(plan, point, usual, runner);
    const std::string text = &point == &usual ? "the usual setting (" + whole_text(point.setting) + ")"
                                              : text_of(point.setting, plan.options.usual) + " (else as usual)";
    recommendation = recommend(constraints, text, figures_in(again, plan.options.out / "again", point.choice.figures.tick_us),
                               plan.dataset.simulated());
    result["setting"] = point.setting;
    result["id"] = id_of(point.setting);
    result["model"] = point.networks.front().name();
    result["chosen_in_interval"] = choice->in_interval;
    result["again"] = again;
  } else {
    recommendation = recommend(constraints, std::nullopt, {}, plan.dataset.simulated());
  }
  result["met"] = recommendation.met;
  result["sentence"] = recommendation.sentence;
  return result;
}

}  // namespace tactile::trade
