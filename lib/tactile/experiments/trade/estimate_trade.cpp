#include "tactile/experiments/trade/estimate_trade.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "tactile/core/runs_below.hpp"
#include "tactile/evaluation/full_run.hpp"
#include "tactile/experiments/trade/measure_points.hpp"
#include "tactile/experiments/trade/time_points.hpp"
#include "tactile/experiments/training_speed.hpp"
#include "tactile/model/definition/model_network.hpp"

namespace tactile::trade {
namespace {

/// A part of steps that each have a file: the first training of each setting. Further trainings cost the same.
struct Steps {
  std::set<std::string> names{};
  std::size_t exist = 0;
  double seconds = 0;  ///< of all, also of those that exist

  double each_s() const { return seconds / static_cast<double>(std::max<std::size_t>(1, names.size())); }
  void add_to(experiments::Estimate& estimate, experiments::EstimatedPart part, double bytes) const {
    part.count = names.size();
    part.exist = exist;
    estimate.add(std::move(part), each_s(), bytes);
  }
};

double samples_in(const windows::Dataset& dataset, const std::vector<std::uint32_t>& runs) {
  return static_cast<double>(std::count_if(
      dataset.samples().begin(), dataset.samples().end(),
      [&](const windows::Sample& sample) { return std::find(runs.begin(), runs.end(), sample.run_index) != runs.end(); }));
}

/// Settings that cost the same time, as `TimedSetting`: networks need not exist here.
std::string timed_name(const TradePoint& point, const TradeNetwork& network) {
  return prediction_name(network, point.setting) + std::to_string(point.setting.rendering.tick.count());
}

/// How many promising combinations there may be.
std::size_t most_corners(const TradeOptions& options, std::size_t designed) {
  constexpr std::size_t fronts = 2;
  if (options.full) return 0;
  double all = 1;  // there may be millions
  for (const TradeFactor& factor : factors_of(options.levels)) all *= static_cast<double>(factor.levels.size());
  return static_cast<std::size_t>(
      std::clamp(all - static_cast<double>(designed), 0.0, static_cast<double>(fronts * options.corners)));
}

}  // namespace

experiments::Estimate estimate_trade(const TradeOptions& requested) {
  constexpr double stream_step_s = 0.19;  // of a training of 800 steps on one core, in 2 to 3 minutes
  constexpr double bytes_of_model = 5.3e6, bytes_of_tick = 30;
  const windows::Dataset dataset(requested.data / "dataset.h5");
  const TradeOptions options = completed(requested, dataset);
  const TradePlan plan = plan_trade(options, dataset);
  const double usual = experiments::measured_training_speed();
  const experiments::WorkCost cost = experiments::work_cost(usual);
  experiments::Estimate estimate{.parts = {}, .cores = options.threads, .images_per_s = usual, .data = dataset.file().string()};

  MeasuredPoints designed{.points = designed_points(plan)};
  remove_what_cannot_be_rendered(plan, designed);
  const std::vector<TradePoint>& points = designed.points;
  const double samples = samples_in(dataset, plan.trainings.front().runs.train);
  const std::vector<std::uint32_t> tested = plan.trainings.front().tested();
  Steps trainings, predictions;
  std::set<std::string> timed;
  double most_ticks = 0;
  for (const TradePoint& point : points) {
    const TradeNetwork network = network_of(plan, point.setting, 0);
    timed.insert(timed_name(point, network));
    if (trainings.names.insert(network.name()).second) {
      trainings.exist += is_file(network.bundle.description()) ? 1 : 0;
      trainings.seconds +=
          cost.training_start + (model::reads_heatmaps(point.setting.kind) ? samples * options.epochs / usual
                                                                           : stream_step_s * network.settings.stream.steps);
    }
    const std::string prediction = prediction_name(network, point.setting);
    if (!predictions.names.insert(prediction).second) continue;
    predictions.exist += is_file(prediction_file(plan, prediction)) ? 1 : 0;
    heatmaps::HeatmapOptions rendering = network.settings.rendering;
    rendering.tick = prediction_tick(network, point.setting.rendering.tick);
    double ticks = 0;
    for (const RunFolder& run : plan.folders(tested))
      ticks += static_cast<double>(evaluation::expected_ticks(run.events(), rendering));
    most_ticks = std::max(most_ticks, ticks);
    predictions.seconds += cost.evaluated_tick * ticks;
  }

  const std::size_t corners = most_corners(options, points.size()), more = options.trainings - 1;
  const auto time_ticks = static_cast<double>(options.timing.ticks) * usual_tick_us * 1e-6;
  trainings.add_to(estimate, {.what = "trainings", .one_thread = true}, bytes_of_model);
  predictions.add_to(estimate, {.what = "predictions of whole runs"}, bytes_of_tick * most_ticks);
  estimate.add({.what = "trainings of combinations, at most", .count = corners, .one_thread = true}, trainings.each_s(),
               bytes_of_model);
  estimate.add({.what = "predictions of combinations, at most", .count = corners}, predictions.each_s(),
               bytes_of_tick * most_ticks);
  // A tenth of the ticks show which combinations are promising.
  if (!options.full) estimate.add({.what = "settings timed first", .count = timed.size(), .is_serial = true}, time_ticks / 10, 0);
  estimate.add({.what = "timed settings, at most", .count = timed.size() + corners, .is_serial = true}, time_ticks, 0);
  estimate.add({.what = "further trainings, at most", .count = more * (trainings.names.size() + corners), .one_thread = true},
               trainings.each_s(), bytes_of_model);
  estimate.add({.what = "further predictions, at most", .count = more * (predictions.names.size() + corners)},
               predictions.each_s(), bytes_of_tick * most_ticks);
  if (options.constraints.any()) {
    estimate.add({.what = "recommendation tried in detect", .count = 1, .is_serial = true},
                 std::chrono::duration<double>(options.trial).count(), 0);
  }
  return estimate;
}

}  // namespace tactile::trade
