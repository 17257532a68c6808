#include "tactile/experiments/trade/recommend_setting.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <set>

#include "tactile/core/json.hpp"
#include "tactile/core/machine.hpp"
#include "tactile/core/version.hpp"
#include "tactile/experiments/file_step.hpp"
#include "tactile/experiments/milliseconds.hpp"
#include "tactile/experiments/run_division.hpp"
#include "tactile/experiments/trade/full_runs.hpp"
#include "tactile/experiments/trade/live_trial.hpp"
#include "tactile/experiments/trade/recommendation.hpp"
#include "tactile/model/training/open_classifier.hpp"

namespace tactile::trade {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// The points that a setting is chosen of: those with all trainings, because fewer have narrower intervals than they should.
/// `detect` has no dense pass: it is measured for comparison only.
struct Candidates {
  explicit Candidates(std::span<const TradePoint> points) {
    std::size_t most = 0;
    for (const TradePoint& point : points) most = std::max(most, point.networks.size());
    for (const TradePoint& point : points) {
      if (!point.setting.sparse) continue;
      if (point.networks.size() < most) {
        ++not_compared;
        continue;
      }
      compared.push_back(&point);
      figures.push_back(point.choice.figures);
    }
  }

  std::vector<const TradePoint*> compared;
  std::vector<results::TradeFigures> figures;  ///< of each of them, on the runs to choose on
  std::size_t not_compared = 0;
};

/// History, tick and factor, and all other differences from the defaults.
std::string whole_text(const TradeSetting& setting) {
  TradeSetting named;
  named.rendering.history = setting.rendering.history;
  named.rendering.tick = setting.rendering.tick;
  named.rendering.factor = setting.rendering.factor;
  return fmt::format("t_h {:g} ms, tick {:g} ms, factor {:g}{}", in_ms(setting.rendering.history), in_ms(setting.rendering.tick),
                     setting.rendering.factor, setting == named ? "" : ", " + text_of(setting, named));
}

/// The runs that some training reports on, ascending.
std::vector<std::uint32_t> reported_runs(const TradePlan& plan, const TradePoint& point) {
  std::set<std::uint32_t> runs;
  for (const TradeNetwork& network : point.networks) {
    const auto& reported = plan.trainings[network.training].runs.reported;
    runs.insert(reported.begin(), reported.end());
  }
  return {runs.begin(), runs.end()};
}

/// Times are taken in turns with those of the usual setting.
std::vector<TimedRun> timed_again(const TradePlan& plan, const TradePoint& point, const TradePoint& usual,
                                  const ProgressCallback& progress) {
  const std::vector<TimedSetting> settings{timed_setting_of(usual), timed_setting_of(point)};
  const std::vector<std::uint32_t> runs = reported_runs(plan, point);
  std::vector<fs::path> recordings;
  for (const RunFolder& run : plan.folders(runs)) recordings.push_back(run.events());
  const auto times = time_ticks(settings, recordings, plan.options.timing, progress);
  std::vector<TimedRun> timed;
  for (std::size_t i = 0; i < runs.size(); ++i) timed.push_back(timed_run(plan.judged.at(runs[i]), times[1].at(i)));
  return timed;
}

/// Measures a setting by each of its networks, on the runs that this one reports on. Uses nothing that was measured before.
results::MeasuredAgain measure_again(const TradePlan& plan, const TradePoint& point, const TradePoint& usual,
                                     const ProgressCallback& progress) {
  const TradeSetting& setting = point.setting;
  const unsigned threads = plan.options.threads;
  std::vector<results::Cell> outcomes;
  for (const TradeNetwork& network : point.networks) {
    const std::vector<std::uint32_t>& runs = plan.trainings[network.training].runs.reported;
    const model::Classifier classifier =
        model::open_classifier(network.bundle.folder, 1, setting.engine, {.precision = setting.precision});
    const std::vector<results::FullRun> predicted =
        classify_full_runs(plan.folders(runs), classifier, {.threads = threads, .tick = setting.rendering.tick}, progress);
    for (std::size_t i = 0; i < runs.size(); ++i) {
      const std::vector<Touch> verdicts =
          evaluation::decided(model::usual_decision(setting.kind, setting.confirmation), predicted[i]);
      outcomes.push_back(cell_of(plan.judged.at(runs[i]), predicted[i], verdicts));
      outcomes.back().training = network.training;
    }
  }
  return {.result = result_of(outcomes, timed_again(plan, point, usual, progress)),
          .model = point.networks.front().name(),
          .trainings = point.networks.size(),
          .runs = plan.names(reported_runs(plan, point))};
}

json weights_of(const TradePoint& point) {
  json weights = json::array();
  for (const TradeNetwork& network : point.networks) weights.push_back(model::read_description(network.bundle).weights_sha256);
  return weights;
}

/// The same as a step.
/// @return  nothing if the budget ended it
std::optional<results::MeasuredAgain> run_again(const Stage& stage, const TradePoint& point, const TradePoint& usual) {
  const TradePlan& plan = stage.plan;
  const std::string id = id_of(point.setting);
  const fs::path file = plan.options.out / "again" / (id + ".json");
  const std::vector<std::uint32_t> reported = reported_runs(plan, point);
  const experiments::Step step = experiments::file_step(
      "again-" + id,
      {{"manifest", plan.dataset.manifest_hash()},
       {"weights", weights_of(point)},
       {"setting", point.setting},
       {"ticks", plan.options.timing.ticks},
       {"runs", plan.names(reported)},
       {"files", experiments::hashes_of_runs(plan.folders(reported))},
       {"machine", cpu_name()},
       {"revision", revision()}},
      file, [&](const ProgressCallback& progress) { write_json(file, measure_again(plan, point, usual, progress)); },
      fmt::format("measuring the chosen setting again, by {} on the runs to report on: {}",
                  point.networks.size() == 1 ? "one network" : fmt::format("{} networks", point.networks.size()),
                  text_of(point.setting, plan.options.usual)));
  if (!stage.budget.finishes([&] { stage.runner.run(step); })) return std::nullopt;
  const json measured = read_json(file);
  return results::JsonView(measured, file.string(), results::MissingMember::is_error).get<results::MeasuredAgain>();
}

/// The chosen setting in `detect`, on the first run that its first network reports on.
/// @return  nothing if there is no trial, or the budget ended it
std::optional<json> run_trial(const Stage& stage, const TradePoint& point) {
  const TradePlan& plan = stage.plan;
  if (plan.options.trial == std::chrono::milliseconds{0}) return std::nullopt;
  const std::string id = id_of(point.setting);
  const fs::path folder = plan.options.out / "trial" / id, file = folder / "trial.json";
  const std::uint32_t run = plan.trainings.front().runs.reported.front();
  const experiments::Step step = experiments::file_step(
      "trial-" + id,
      {{"weights", weights_of(point).front()},
       {"setting", point.setting},
       {"run", plan.dataset.runs()[run].events_sha256},
       {"ms", plan.options.trial.count()},
       {"machine", cpu_name()},
       {"revision", revision()}},
      file,
      [&](const ProgressCallback& progress) {
        write_json(file, run_live_trial(point.setting,
                                        {.program = plan.options.program,
                                         .run = plan.dataset.run_folder(run),
                                         .model = point.networks.front().bundle.folder,
                                         .folder = folder,
                                         .length = plan.options.trial},
                                        progress));
      },
      fmt::format("the chosen setting in detect over loopback, {:g} s",
                  std::chrono::duration<double>(plan.options.trial).count()));
  if (!stage.budget.finishes([&] { stage.runner.run(step); })) return std::nullopt;
  return read_json(file);
}

/// Measures the chosen point again and tries it in `detect`.
/// @return  the recommendation in words; `result` gets what was measured
Recommendation confirm(const Stage& stage, const TradePoint& point, const TradePoint& usual,
                       results::TradeRecommendation& result) {
  const TradePlan& plan = stage.plan;
  const std::string text = &point == &usual ? "the usual setting (" + whole_text(point.setting) + ")"
                                            : text_of(point.setting, plan.options.usual) + " (else as usual)";
  result.setting = values_of(point.setting);
  result.id = id_of(point.setting);
  result.model = point.networks.front().name();
  result.again = run_again(stage, point, usual);
  const std::optional<results::MeasuredAgain>& again = result.again;
  const bool has_trial = plan.options.trial > std::chrono::milliseconds{0};
  const std::optional<json> trial = again ? run_trial(stage, point) : std::nullopt;
  if (!again || (has_trial && !trial)) {
    return {.met = false,
            .sentence = fmt::format("The setting chosen for {}, {}, is not confirmed: {}.", text_of(plan.options.constraints),
                                    text, budget_words(plan, again ? "its trial in 'detect' ended" : "it was measured again"))};
  }
  if (trial) result.trial = *trial;
  results::TradeFigures figures = again->result.figures;
  figures.tick_us = point.choice.figures.tick_us;
  Recommendation recommendation =
      recommend(plan.options.constraints, text, figures, trial ? std::optional(live_trial_in(*trial)) : std::nullopt,
                plan.dataset.simulated());
  if (const std::string on_front = text_of(point.front_probability); !on_front.empty())
    recommendation.sentence += fmt::format(" It is {}.", on_front);
  return recommendation;
}

}  // namespace

results::TradeRecommendation recommend_setting(const Stage& stage, std::span<const TradePoint> points) {
  const TradeConstraints& constraints = stage.plan.options.constraints;
  results::TradeRecommendation result{.wish = constraints};
  const Candidates candidates(points);
  Recommendation recommendation;
  if (const auto choice = constraints.any() ? choose(constraints, candidates.figures) : std::nullopt) {
    result.chosen_in_interval = choice->in_interval;
    recommendation = confirm(stage, *candidates.compared[choice->index], points.front(), result);
  } else {
    recommendation.sentence = why_none(constraints, candidates.figures, candidates.not_compared, stage.plan.dataset.simulated());
  }
  result.met = recommendation.met;
  result.sentence = recommendation.sentence;
  return result;
}

}  // namespace tactile::trade
