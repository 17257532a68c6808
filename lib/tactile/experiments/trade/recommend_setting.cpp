#include "tactile/experiments/trade/recommend_setting.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "tactile/core/json.hpp"
#include "tactile/core/machine.hpp"
#include "tactile/core/version.hpp"
#include "tactile/experiments/file_step.hpp"
#include "tactile/experiments/milliseconds.hpp"
#include "tactile/experiments/trade/live_trial.hpp"
#include "tactile/experiments/trade/recommendation.hpp"

namespace tactile::trade {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// The points that a setting is chosen of: those with all trainings, because fewer have narrower intervals than they should.
struct Candidates {
  explicit Candidates(std::span<const TradePoint> points) {
    std::size_t most = 0;
    for (const TradePoint& point : points) most = std::max(most, point.networks.size());
    for (const TradePoint& point : points) {
      if (point.networks.size() < most) {
        ++not_compared;
        continue;
      }
      compared.push_back(&point);
      figures.push_back(point.choice);
    }
  }

  std::vector<const TradePoint*> compared;
  std::vector<results::TradeResult> figures;  ///< of each of them, on the runs to choose on
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
      {{"weights", model::read_description(point.networks.front().bundle).weights_sha256},
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

/// Tries the chosen point in `detect`.
/// @return  the recommendation in words; `result` gets what was measured
Recommendation confirm(const Stage& stage, const TradePoint& point, results::TradeRecommendation& result) {
  const TradePlan& plan = stage.plan;
  const bool is_usual = point.setting == plan.options.usual;
  const std::string text = is_usual ? "the usual setting (" + whole_text(point.setting) + ")"
                                    : text_of(point.setting, plan.options.usual) + " (else as usual)";
  result.setting = values_of(point.setting);
  result.id = id_of(point.setting);
  result.model = point.networks.front().name();
  const std::optional<json> trial = run_trial(stage, point);
  if (!trial && plan.options.trial > std::chrono::milliseconds{0}) {
    return {.met = false,
            .sentence = fmt::format("The setting chosen for {}, {}, is not confirmed: {}.", text_of(plan.options.constraints),
                                    text, budget_words(plan, "its trial in 'detect' ended"))};
  }
  if (trial) result.trial = *trial;
  Recommendation recommendation =
      recommend(plan.options.constraints, text, point.reported, trial ? std::optional(live_trial_in(*trial)) : std::nullopt,
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
    recommendation = confirm(stage, *candidates.compared[choice->index], result);
  } else {
    recommendation.sentence = why_none(constraints, candidates.figures, candidates.not_compared, stage.plan.dataset.simulated());
  }
  result.met = recommendation.met;
  result.sentence = recommendation.sentence;
  return result;
}

}  // namespace tactile::trade
