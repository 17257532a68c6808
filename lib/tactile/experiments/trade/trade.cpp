#include "tactile/experiments/trade/trade.hpp"

#include <fmt/core.h>

#include <utility>

#include "tactile/core/command_lock.hpp"
#include "tactile/experiments/trade/judge_points.hpp"
#include "tactile/experiments/trade/live_trial.hpp"
#include "tactile/experiments/trade/recommend_setting.hpp"
#include "tactile/experiments/trade/time_points.hpp"
#include "tactile/experiments/trade/trade_results.hpp"

namespace tactile::trade {
namespace {

/// Announces the parts of the work, each once one of its steps is due: parts whose steps are all kept are not mentioned.
class Parts {
 public:
  Parts(const TradeOptions& options, experiments::StepCallback on_step)
      : on_step_(std::move(on_step)),
        count_(1 + (options.full ? 0 : 1) + (options.trainings > 1 ? 1 : 0) + (options.constraints.any() ? 1 : 0)) {}

  void begin(const std::string& description) { part_ = fmt::format("part {} of {}: {}", ++begun_, count_, description); }

  void on_step(const std::string& step, bool kept) {
    if (!on_step_) return;
    if (!kept && !part_.empty()) on_step_(std::exchange(part_, {}), false);
    on_step_(step, kept);
  }

 private:
  experiments::StepCallback on_step_;
  int count_, begun_ = 0;
  std::string part_;  ///< not announced yet
};

MeasuredPoints measure_design(const Stage& stage, Parts& parts) {
  const TradeOptions& options = stage.plan.options;
  MeasuredPoints measured{.points = designed_points(stage.plan)};
  parts.begin(
      fmt::format("{}, {} settings", options.full ? "every combination" : "one change at a time", measured.points.size()));
  if (options.full) {
    measure(stage, "times", options.timing.ticks, measured);
  } else {
    // Some ticks are enough to see what looks promising. Then all settings are timed together.
    constexpr std::uint64_t share = 10;
    measure(stage, "times-design", (options.timing.ticks + share - 1) / share, measured);
    const std::size_t before = measured.points.size();
    const auto corners = promising_corners(options.usual, options.levels, known_outcomes(measured.points), options.corners);
    add_points(measured.points, corners, "corner");
    parts.begin(fmt::format("{} combinations that look promising", measured.points.size() - before));
    measure(stage, "times", options.timing.ticks, measured);
  }
  if (options.trainings > 1)
    parts.begin(fmt::format("the usual setting and those that may be on a front, up to {} trainings", options.trainings));
  measure_all_trainings(stage, measured);
  return measured;
}

}  // namespace

TradeSummary run_trade(const TradeOptions& requested, const experiments::NewProgress& new_progress,
                       const experiments::StepCallback& on_step) {
  Budget budget(requested.budget_minutes);
  const windows::Dataset dataset(requested.data / "dataset.h5");
  const TradeOptions options = completed(requested, dataset);
  Parts parts(options, on_step);
  const CommandLock lock(options.out, "tactile trade");
  experiments::StepRunner runner(
      {.folder = options.out,
       .program = options.program,
       .threads = options.threads,
       .new_progress = [&] { return budget.limited(new_progress ? new_progress() : ProgressCallback{}); },
       .on_step = [&](const std::string& step, bool kept) { parts.on_step(step, kept); },
       .slurm = options.slurm});
  const TradePlan plan = plan_trade(options, dataset);
  NetworkTrainer trainer(plan, runner, budget);
  const Stage stage{plan, trainer, runner, budget};
  const MeasuredPoints measured = measure_design(stage, parts);
  if (options.constraints.any()) parts.begin("a setting for the constraints");
  const results::TradeRecommendation recommendation = recommend_setting(stage, measured.points);
  const results::Trade trade = results_of(plan, {.points = measured.points,
                                                 .not_measured = measured.not_measured,
                                                 .recommendation = recommendation,
                                                 .unfinished = trainer.unfinished(),
                                                 .steps = runner.records()});
  write_trade(trade, options.out);
  TradeSummary summary{.trade = trade, .file = options.out / "trade.json", .done = runner.done_now(), .kept = runner.kept()};
  for (const TradePoint& point : measured.points) {
    if (id_of(point.setting) == recommendation.id)
      summary.detect_options = detect_options(point.setting, point.networks.front().bundle.folder);
  }
  return summary;
}

}  // namespace tactile::trade
