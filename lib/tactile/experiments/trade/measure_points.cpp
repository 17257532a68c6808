#include "tactile/experiments/trade/measure_points.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "tactile/core/error.hpp"
#include "tactile/experiments/file_step.hpp"
#include "tactile/experiments/run_division.hpp"
#include "tactile/experiments/trade/full_runs.hpp"
#include "tactile/experiments/trade/judge_points.hpp"
#include "tactile/experiments/trade/time_points.hpp"
#include "tactile/heatmaps/render_samples.hpp"
#include "tactile/model/bundle/temperature.hpp"
#include "tactile/model/training/open_classifier.hpp"

namespace tactile::trade {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using nlohmann::json;

constexpr microseconds shortest_prediction_tick{100};  // some 40 000 heatmaps a run

/// @throws Error  if the dataset cannot render a setting
void check_setting(const TradePlan& plan, const TradeSetting& setting) {
  const TradeNetwork network = network_of(plan, setting, 0);
  heatmaps::check_renders(plan.dataset, network.settings.rendering);
  check(setting.rendering);
  const microseconds tick = prediction_tick(network, setting.rendering.tick);
  if (tick >= shortest_prediction_tick) return;
  throw Error(fmt::format("its tick and the network's have only {} us in common; expected {} us at least", tick.count(),
                          shortest_prediction_tick.count()));
}

/// Gives each point the network of its first training, and removes those that have none.
void take_networks(const Stage& stage, MeasuredPoints& measured) {
  for (TradePoint& point : measured.points) {
    const std::vector<TradeNetwork> trained = stage.trainer.trained_for(point.setting);
    if (!trained.empty()) point.networks = {trained.front()};
  }
  remove_unless(
      measured, stage.plan.options.usual, [](const TradePoint& point) { return !point.networks.empty(); },
      budget_words(stage.plan, "its network was trained"));
  expect_usual(stage, measured, "the network of the usual setting is not trained yet");
}

experiments::Step step_to_predict(const TradePlan& plan, const TradeNetwork& network, const TradeSetting& setting) {
  const std::string name = prediction_name(network, setting);
  const fs::path file = prediction_file(plan, name);
  const microseconds tick = prediction_tick(network, setting.rendering.tick);
  const std::vector<std::uint32_t> tested = plan.trainings[network.training].tested();
  const model::ModelDescription description = model::read_description(network.bundle);
  const nlohmann::json inputs = {{"manifest", plan.dataset.manifest_hash()},
                                 {"weights", description.weights_sha256},
                                 {"temperature", model::read_temperature(network.bundle, description).value},
                                 {"runs", plan.names(tested)},
                                 {"events", plan.hashes(tested)},
                                 {"tick_us", tick.count()},
                                 {"engine", name_of(setting.engine)},
                                 {"precision", name_of(setting.precision)}};
  return experiments::file_step(
      name, inputs, file,
      [&plan, file, tick, network, setting, tested](const ProgressCallback& progress) {
        const model::Classifier classifier =
            model::open_classifier(network.bundle.folder, 1, setting.engine, {.precision = setting.precision});
        write_full_runs(file, classify_full_runs(plan.folders(tested), classifier,
                                                 {.threads = plan.options.threads, .tick = tick}, progress));
      },
      text_of(plan, network, tick, setting.engine, setting.precision));
}

/// The time that `left` further steps take, if they take as long as the `done` ones.
std::string time_left(Clock::time_point begun, std::size_t done, std::size_t left) {
  if (done == 0) return {};
  const double passed_s = std::chrono::duration<double>(Clock::now() - begun).count();
  const double left_s = passed_s / static_cast<double>(done) * static_cast<double>(left);
  return left_s < 90 ? fmt::format(", about {:.0f} s left", left_s) : fmt::format(", about {:.0f} min left", left_s / 60);
}

/// Adds the predictions of all networks of the points that are missing, as far as the budget allows.
/// @param reserve_s  time that what comes after needs   @param each_s  the same for each prediction
void predict(const Stage& stage, MeasuredPoints& measured, double reserve_s, double each_s) {
  std::vector<experiments::Step> due;
  std::set<std::string> seen;
  const auto run = [&](const experiments::Step& step) {
    stage.runner.run(step);
    measured.predictions[step.name] = read_full_runs(prediction_file(stage.plan, step.name));
  };
  for (const TradePoint& point : measured.points) {
    for (const TradeNetwork& network : point.networks) {
      const std::string name = prediction_name(network, point.setting);
      if (measured.predictions.contains(name) || !seen.insert(name).second) continue;
      const experiments::Step step = step_to_predict(stage.plan, network, point.setting);
      if (stage.runner.is_done(step)) {
        run(step);
      } else {
        due.push_back(step);
      }
    }
  }
  const Clock::time_point begun = Clock::now();
  for (std::size_t i = 0; i < due.size(); ++i) {
    const double after_s = reserve_s + each_s * static_cast<double>(measured.predictions.size() + 1);
    if (!stage.budget.allows(longest_s(stage.runner, "said-") + after_s)) return;
    due[i].description = fmt::format("judging {} of {}, at every tick of its runs: {}{}", i + 1, due.size(), due[i].description,
                                     time_left(begun, i, due.size() - i));
    if (!stage.budget.finishes([&] { run(due[i]); })) return;
  }
}

/// Leaves each point the networks whose predictions are there, and removes those without.
void keep_predicted(const Stage& stage, MeasuredPoints& measured) {
  for (TradePoint& point : measured.points) {
    const auto is_missing = [&](const TradeNetwork& network) {
      return !measured.predictions.contains(prediction_name(network, point.setting));
    };
    point.networks.erase(std::find_if(point.networks.begin(), point.networks.end(), is_missing), point.networks.end());
  }
  remove_unless(
      measured, stage.plan.options.usual, [](const TradePoint& point) { return !point.networks.empty(); },
      budget_words(stage.plan, "its verdicts were predicted"));
  expect_usual(stage, measured, "the verdicts of the usual setting are not predicted yet");
}

/// Whether a setting gets more trainings. The usual one does: all others are compared with it.
bool may_be_on_a_front(const TradePoint& point) {
  constexpr double least = 0.025;
  const results::FrontProbability& probability = point.front_probability;
  return point.design == "usual" || point.on_accuracy_front || point.on_delay_front ||
         probability.accuracy.value_or(0) >= least || probability.delay.value_or(0) >= least;
}

}  // namespace

std::string budget_words(const TradePlan& plan, const std::string& before) {
  return fmt::format("the budget of {:g} minutes was used up before {}", plan.options.budget_minutes.value_or(0), before);
}

void expect_usual(const Stage& stage, const MeasuredPoints& measured, const std::string& problem) {
  if (!measured.points.empty() && measured.points.front().setting == stage.plan.options.usual) return;
  throw Error(fmt::format("{}; expected time for it. {}", problem, stage.trainer.unfinished()));
}

void remove_unless(MeasuredPoints& measured, const TradeSetting& usual, const std::function<bool(const TradePoint&)>& stays,
                   const std::string& why) {
  for (const TradePoint& point : measured.points) {
    if (!stays(point)) measured.not_measured.push_back({text_of(point.setting, usual), why});
  }
  std::erase_if(measured.points, [&](const TradePoint& point) { return !stays(point); });
}

void remove_what_cannot_be_rendered(const TradePlan& plan, MeasuredPoints& measured) {
  std::map<std::string, std::string> errors;  // by setting
  for (const TradePoint& point : measured.points) {
    try {
      check_setting(plan, point.setting);
    } catch (const Error& e) {
      if (point.setting == plan.options.usual) throw;
      errors[id_of(point.setting)] = e.what();
    }
  }
  for (const auto& [id, error] : errors) {
    remove_unless(
        measured, plan.options.usual, [&, &id = id](const TradePoint& point) { return id_of(point.setting) != id; }, error);
  }
}

std::string prediction_name(const TradeNetwork& network, const TradeSetting& setting) {
  return fmt::format("said-{}-{}us-{}-{}", network.name(), prediction_tick(network, setting.rendering.tick).count(),
                     name_of(setting.engine), name_of(setting.precision));
}

fs::path prediction_file(const TradePlan& plan, const std::string& name) { return plan.options.out / "said" / (name + ".json"); }

const TimesOfRuns& PointTimes::of(const TradePoint& point) const {
  return times[static_cast<std::size_t>(std::find(settings.begin(), settings.end(), timed_setting_of(point)) - settings.begin())];
}

void measure(const Stage& stage, const std::string& step_of_times, std::uint64_t ticks, MeasuredPoints& measured) {
  remove_what_cannot_be_rendered(stage.plan, measured);
  std::vector<TradeNetwork> networks;
  for (const TradePoint& point : measured.points) networks.push_back(network_of(stage.plan, point.setting, 0));
  const double timing_each_s = timing_s(stage, ticks, measured.times);
  double reserve_s = 0;
  if (stage.plan.options.budget_minutes) {
    // The usual setting first: all others are compared with it, and it shows what they take. Two settings at least can be timed.
    stage.trainer.train({networks.front()}, 0, 0);
    measured.points.front().networks = stage.trainer.trained_for(stage.plan.options.usual);
    predict(stage, measured, 0, 0);
    reserve_s = 2 * timing_s(stage, stage.plan.options.timing.ticks, measured.times);
  }
  stage.trainer.train(networks, reserve_s, timing_each_s + longest_s(stage.runner, "said-"));
  take_networks(stage, measured);
  predict(stage, measured, reserve_s, timing_each_s);
  keep_predicted(stage, measured);
  time_points(stage, step_of_times, ticks, measured);
  judge(stage.plan, measured);
}

void measure_all_trainings(const Stage& stage, MeasuredPoints& measured) {
  const TradeOptions& options = stage.plan.options;
  const unsigned all = options.trainings;
  // The recommended setting runs in `detect`, which takes some seconds to start.
  const double reserve_s = options.constraints.any() ? 1.5 * std::chrono::duration<double>(options.trial).count() : 0;
  for (unsigned trainings = std::min(2U, all); trainings > 1;) {
    std::vector<TradeNetwork> networks;
    for (const TradePoint& point : measured.points) {
      for (unsigned training = 1; training < trainings && may_be_on_a_front(point); ++training)
        networks.push_back(network_of(stage.plan, point.setting, training));
    }
    const std::size_t before = stage.trainer.trained();
    stage.trainer.train(networks, reserve_s, longest_s(stage.runner, "said-"));
    for (TradePoint& point : measured.points) {
      if (may_be_on_a_front(point)) point.networks = stage.trainer.trained_for(point.setting);
    }
    predict(stage, measured, reserve_s, 0);
    // Other settings that share these predictions need no more time.
    for (TradePoint& point : measured.points) point.networks = stage.trainer.trained_for(point.setting);
    keep_predicted(stage, measured);
    judge(stage.plan, measured);
    if (stage.budget.ended() || (trainings == all && stage.trainer.trained() == before)) return;
    trainings = std::min(2 * trainings, all);
  }
}

}  // namespace tactile::trade
