#include "tactile/experiments/trade/measure_points.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/machine.hpp"
#include "tactile/core/version.hpp"
#include "tactile/experiments/experiment_json.hpp"
#include "tactile/experiments/file_step.hpp"
#include "tactile/experiments/run_division.hpp"
#include "tactile/experiments/trade/full_runs.hpp"
#include "tactile/experiments/trade/judge_points.hpp"
#include "tactile/experiments/training_step.hpp"
#include "tactile/heatmaps/render_samples.hpp"
#include "tactile/model/training/open_classifier.hpp"
#include "tactile/model/training/train_model.hpp"

namespace tactile::trade {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using nlohmann::json;

constexpr microseconds shortest_prediction_tick{100};  // some 40 000 heatmaps a run

template <class Stays>
void remove_unless(MeasuredPoints& measured, const TradeSetting& usual, Stays stays, const std::string& why) {
  for (const TradePoint& point : measured.points) {
    if (!stays(point)) measured.not_measured.push_back({text_of(point.setting, usual), why});
  }
  std::erase_if(measured.points, [&](const TradePoint& point) { return !stays(point); });
}

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

/// Gives each point its trained networks, and removes those that have none, or a gate that their network lacks.
void take_networks(const TradePlan& plan, const NetworkTrainer& trainer, MeasuredPoints& measured) {
  const TradeSetting& usual = plan.options.usual;
  for (TradePoint& point : measured.points) point.networks = trainer.trained_for(point.setting);
  if (!measured.points.empty() && measured.points.front().networks.empty())
    throw Error("the network of the usual setting is not trained yet; expected time for it. " + trainer.unfinished());
  remove_unless(
      measured, usual, [](const TradePoint& point) { return !point.networks.empty(); },
      fmt::format("the budget of {:g} minutes was used up before its network was trained",
                  plan.options.budget_minutes.value_or(0)));
  remove_unless(
      measured, usual,
      [](const TradePoint& point) {
        return !point.setting.gate || model::read_description(point.networks.front().bundle).gate.has_value();
      },
      "its network was made without a gate");
  if (measured.points.empty() || !(measured.points.front().setting == usual))
    throw Error("the usual setting has a gate, and its network none; expected one that this version of 'tactile train' made");
}

fs::path file_of(const TradePlan& plan, const std::string& name) { return plan.options.out / "said" / (name + ".json"); }

experiments::Step step_to_predict(const TradePlan& plan, const TradeNetwork& network, const TradeSetting& setting) {
  const std::string name = prediction_name(network, setting);
  const fs::path file = file_of(plan, name);
  const microseconds tick = prediction_tick(network, setting.rendering.tick);
  return experiments::file_step(
      name,
      {{"manifest", plan.dataset.manifest_hash()},
       {"weights", model::read_description(network.bundle).weights_sha256},
       {"runs", names_of(plan.dataset, plan.tested.indexes)},
       {"tick_us", tick.count()},
       {"engine", name_of(setting.engine)},
       {"precision", name_of(setting.precision)}},
      file,
      [&plan, file, tick, network, setting](const ProgressCallback& progress) {
        const model::Classifier classifier =
            model::open_classifier(network.bundle.folder, 1, setting.engine, {.precision = setting.precision});
        write_full_runs(file,
                        classify_full_runs(plan.dataset, plan.tested.indexes, classifier, tick, plan.options.threads, progress));
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

/// Adds the predictions of all networks of the points that are missing.
void predict(const TradePlan& plan, experiments::StepRunner& runner, MeasuredPoints& measured) {
  std::vector<experiments::Step> due;
  std::set<std::string> seen;
  const auto run = [&](const experiments::Step& step) {
    runner.run(step);
    measured.predictions[step.name] = read_full_runs(file_of(plan, step.name));
  };
  for (const TradePoint& point : measured.points) {
    for (const TradeNetwork& network : point.networks) {
      const std::string name = prediction_name(network, point.setting);
      if (measured.predictions.contains(name) || !seen.insert(name).second) continue;
      const experiments::Step step = step_to_predict(plan, network, point.setting);
      if (runner.is_done(step)) {
        run(step);
      } else {
        due.push_back(step);
      }
    }
  }
  const Clock::time_point begun = Clock::now();
  for (std::size_t i = 0; i < due.size(); ++i) {
    due[i].description = fmt::format("judging {} of {}, at every tick of {} runs: {}{}", i + 1, due.size(),
                                     plan.tested.indexes.size(), due[i].description, time_left(begun, i, due.size() - i));
    run(due[i]);
  }
}

json json_of(const TimedSetting& setting) {
  return {{"rendering", setting.rendering},
          {"engine", name_of(setting.engine)},
          {"precision", name_of(setting.precision)},
          {"sparse", setting.sparse},
          {"weights", model::read_description({setting.model}).weights_sha256}};
}

PointTimes time_points(const TradePlan& plan, std::span<const TradePoint> points, const std::string& step_name,
                       experiments::StepRunner& runner) {
  PointTimes timed;
  json timed_json = json::array();
  for (const TradePoint& point : points) {
    const TimedSetting setting = timed_setting_of(point);
    if (std::find(timed.settings.begin(), timed.settings.end(), setting) != timed.settings.end()) continue;
    timed.settings.push_back(setting);
    timed_json.push_back(json_of(setting));
  }
  const TickTimesOptions& timing = plan.options.timing;
  const fs::path file = plan.options.out / "times" / (step_name + ".json");
  runner.run(experiments::file_step(
      step_name,
      {{"manifest", plan.dataset.manifest_hash()},
       {"runs", names_of(plan.dataset, plan.tested.indexes)},
       {"ways", timed_json},
       {"machine", cpu_name()},
       {"revision", revision()},
       {"pieces", timing.pieces},
       {"ticks", timing.ticks},
       {"turns", timing.turns}},
      file,
      [&](const ProgressCallback& progress) {
        write_times(file, time_ticks(timed.settings, plan.tested.recordings, timing, progress));
      },
      fmt::format("timing ticks of {} settings, in turns, at {} times of each of {} runs", timed.settings.size(),
                  timing.pieces * timing.ticks, plan.tested.indexes.size())));
  timed.times = read_times(file);
  if (timed.times.size() != timed.settings.size())
    throw Error(file.string() + ": times of other settings; expected those measured");
  return timed;
}

}  // namespace

experiments::Step NetworkTrainer::step_for(const TradeNetwork& network) const {
  const TradeOptions& options = plan_.options;
  return experiments::training_step(plan_.dataset, network.settings, network.bundle,
                                    {options.data, options.models, experiments::from_folder(options.models, options.out)});
}

double NetworkTrainer::longest_training_s() const {
  double longest = 0;
  for (const experiments::StepRecord& record : runner_.records()) {
    if (record.name.starts_with("train-")) longest = std::max(longest, record.seconds);
  }
  return longest;
}

bool NetworkTrainer::budget_allows_training() const {
  if (!plan_.options.budget_minutes) return true;
  const double passed = std::chrono::duration<double>(Clock::now() - begun_).count();
  return passed + longest_training_s() < 60 * *plan_.options.budget_minutes;
}

void NetworkTrainer::train(const std::vector<TradeNetwork>& networks) {
  std::vector<experiments::Step> kept;
  std::vector<const TradeNetwork*> due;
  std::set<std::string> seen = trained_;
  for (const TradeNetwork& network : networks) {
    if (!seen.insert(network.name()).second) continue;
    if (model::state_of(network.bundle, plan_.dataset, network.settings) == model::BundleState::unchanged) {
      kept.push_back(step_for(network));
      trained_.insert(network.name());
    } else {
      due.push_back(&network);
    }
  }
  runner_.run_side_by_side(kept);
  const std::size_t at_once = plan_.options.budget_minutes ? plan_.options.threads : std::max<std::size_t>(due.size(), 1);
  for (std::size_t begin = 0; begin < due.size(); begin += at_once) {
    if (!budget_allows_training()) {
      budget_ended_ = true;
      return;
    }
    std::vector<experiments::Step> batch;
    for (std::size_t i = begin; i < std::min(begin + at_once, due.size()); ++i) {
      batch.push_back(step_for(*due[i]));
      batch.back().description = fmt::format("training {} of {}: {}", i + 1, due.size(), text_of(plan_, *due[i]));
      trained_.insert(due[i]->name());
    }
    begun_trainings_ += batch.size();
    runner_.run_side_by_side(batch);
  }
}

std::vector<TradeNetwork> NetworkTrainer::trained_for(const TradeSetting& setting) const {
  std::vector<TradeNetwork> networks;
  for (unsigned training = 0; training < plan_.options.seeds; ++training) {
    networks.push_back(network_of(plan_, setting, training));
    if (trained_.contains(networks.back().name())) continue;
    networks.pop_back();
    break;
  }
  return networks;
}

std::string NetworkTrainer::unfinished() const {
  if (!budget_ended_) return {};
  const double minutes = plan_.options.budget_minutes.value_or(0), training = longest_training_s() / 60;
  if (begun_trainings_ > 0 && training < minutes) {
    return fmt::format(
        "The budget of {:g} minutes ended the work. Run the same command again: it keeps all that is done, and resumes.",
        minutes);
  }
  return fmt::format(
      "The budget of {:g} minutes ended the work, and is too short for a training{}. Run the same command with a larger "
      "--budget-minutes: it keeps all that is done, and resumes.",
      minutes, training > 0 ? fmt::format(" of {:.2g} minutes", training) : std::string());
}

std::string prediction_name(const TradeNetwork& network, const TradeSetting& setting) {
  return fmt::format("said-{}-{}us-{}-{}", network.name(), prediction_tick(network, setting.rendering.tick).count(),
                     name_of(setting.engine), name_of(setting.precision));
}

const TimesOfRuns& PointTimes::of(const TradePoint& point) const {
  return times[static_cast<std::size_t>(std::find(settings.begin(), settings.end(), timed_setting_of(point)) - settings.begin())];
}

void measure(const TradePlan& plan, const std::string& step_of_times, NetworkTrainer& trainer, experiments::StepRunner& runner,
             MeasuredPoints& measured) {
  remove_what_cannot_be_rendered(plan, measured);
  std::vector<TradeNetwork> networks;
  for (const TradePoint& point : measured.points) networks.push_back(network_of(plan, point.setting, 0));
  trainer.train(networks);
  take_networks(plan, trainer, measured);
  predict(plan, runner, measured);
  measured.times = time_points(plan, measured.points, step_of_times, runner);
  judge(plan, measured);
}

void measure_all_seeds(const TradePlan& plan, NetworkTrainer& trainer, experiments::StepRunner& runner,
                       MeasuredPoints& measured) {
  for (;;) {
    std::vector<TradeNetwork> networks;
    for (const TradePoint& point : measured.points) {
      if (!point.on_accuracy_front && !point.on_delay_front && &point != &measured.points.front()) continue;
      for (unsigned training = 1; training < plan.options.seeds; ++training)
        networks.push_back(network_of(plan, point.setting, training));
    }
    const std::size_t before = trainer.trained();
    trainer.train(networks);
    if (trainer.trained() == before) return;
    for (TradePoint& point : measured.points) point.networks = trainer.trained_for(point.setting);
    predict(plan, runner, measured);
    judge(plan, measured);
  }
}

json time_cost_growth(const TradePlan& plan, experiments::StepRunner& runner) {
  constexpr std::size_t enough_recordings = 3;
  std::vector<fs::path> recordings;
  for (std::size_t i = 0; i < std::min(plan.train.size(), enough_recordings); ++i)
    recordings.push_back(plan.dataset.run_folder(plan.train[i]) / "events.aedat4");
  const GrowthOptions& growth = plan.options.growth_options;
  json histories = json::array(), sensors = json::array();
  for (const microseconds history : growth.histories) histories.push_back(history.count());
  for (const events::SensorSize& sensor : growth.sensors) sensors.push_back({sensor.width, sensor.height});
  const fs::path file = plan.options.out / "growth.json";
  runner.run(experiments::file_step(
      "growth",
      {{"manifest", plan.dataset.manifest_hash()},
       {"machine", cpu_name()},
       {"revision", revision()},
       {"rates", growth.rates},
       {"histories_us", histories},
       {"sensors", sensors},
       {"usual_rate", growth.usual_rate},
       {"pieces", growth.pieces},
       {"ticks", growth.ticks},
       {"turns", growth.turns}},
      file,
      [&](const ProgressCallback& progress) {
        write_json(file, measure_growth(moving_events(recordings), plan.dataset.sensor(), growth, progress));
      },
      fmt::format("timing ticks at {} event rates, {} histories and {} sensor sizes", growth.rates.size(),
                  growth.histories.size(), growth.sensors.size())));
  return read_json(file);
}

}  // namespace tactile::trade
