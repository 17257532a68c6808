#include "tactile/trade/trade.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <mutex>
#include <numeric>
#include <set>
#include <thread>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/machine.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/core/version.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/evaluation/evaluation.hpp"
#include "tactile/heatmaps/render_samples.hpp"
#include "tactile/model/classifier.hpp"
#include "tactile/model/library.hpp"
#include "tactile/model/train_model.hpp"
#include "tactile/study/folder_lock.hpp"
#include "tactile/study/study_json.hpp"
#include "tactile/study/study_runs.hpp"
#include "tactile/study/training_step.hpp"
#include "tactile/trade/pareto_front.hpp"
#include "tactile/trade/run_said.hpp"
#include "tactile/trade/trade_figures.hpp"

namespace tactile {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using Clock = std::chrono::steady_clock;

constexpr microseconds shortest_tick_said{100};  // some 40 000 heatmaps a run

double in_ms(microseconds us) { return static_cast<double>(us.count()) / 1000; }

json hash_of_file(const fs::path& file) { return fs::is_regular_file(file) ? json(sha256_of_file(file)) : json(); }

json json_of(const TimedWay& way) {
  return {{"rendering", way.rendering},
          {"engine", name_of(way.engine)},
          {"precision", name_of(way.precision)},
          {"sparse", way.sparse},
          {"weights", read_description({way.model}).weights_sha256}};
}

/// A network that settings share, and one seed of it.
struct TradeNetwork {
  ModelSettings settings;
  ModelBundle bundle;

  std::string name() const { return bundle.name(); }
};

/// A setting, and what is measured of it.
struct TradePoint {
  TradeSetting setting;
  std::string design;                       ///< "usual", "one", "corner", "all"
  std::vector<TradeNetwork> networks = {};  ///< one for each seed
  TradeResult choice = {}, reported = {};
  std::optional<TradeDifference> difference = {};  ///< to the usual setting, on the reported runs
  bool on_accuracy_front = false, on_delay_front = false;
};

struct NotMeasured {
  std::string setting, why;
};

class Trade {
 public:
  Trade(const TradeOptions& options, const NewProgress& new_progress, const std::function<void(const std::string&, bool)>& tell)
      : options_(options),
        threads_(options.threads > 0 ? options.threads : std::max(1U, std::thread::hardware_concurrency())),
        begun_(Clock::now()),
        lock_(options.out, "tactile trade"),
        runner_({.folder = options.out,
                 .program = options.program,
                 .threads = threads_,
                 .new_progress = new_progress,
                 .tell = tell}) {}

  TradeSummary run() {
    const Dataset dataset(options_.data / "dataset.h5");
    dataset_ = &dataset;
    divide_runs();
    const auto design =
        options_.full ? all_combinations(options_.usual, options_.levels) : one_at_a_time(options_.usual, options_.levels);
    // The usual setting first: all others are told by their difference to it.
    add(options_.usual, "usual");
    for (const TradeSetting& setting : design) add(setting, options_.full ? "all" : "one");
    measure("times-design");
    if (!options_.full) {
      const std::size_t before = points_.size();
      for (const TradeSetting& corner : promising_corners(options_.usual, options_.levels, outcomes(), options_.corners))
        add(corner, "corner");
      if (points_.size() > before) measure("times");
    }
    sow_the_front();
    if (options_.growth) measure_cost_growth();
    recommend_one();
    TradeSummary summary;
    summary.trade = write_results();
    summary.file = options_.out / "trade.json";
    summary.done = runner_.done_now();
    summary.kept = runner_.records().size() - runner_.done_now();
    return summary;
  }

 private:
  // --- which runs

  void divide_runs() {
    const StudyRuns runs = study_runs(*dataset_, options_.train_run, options_.choice_runs);
    if (runs.choice.empty()) {
      throw Error(
          fmt::format("{}: no runs ({}) to choose settings on beside others to report on; expected three runs of an object "
                      "at least, or other --choice-runs",
                      dataset_->file().string(), fmt::join(options_.choice_runs, ", ")));
    }
    train_runs_ = runs.train;
    choice_count_ = runs.choice.size();
    tested_ = runs.choice;
    tested_.insert(tested_.end(), runs.reported.begin(), runs.reported.end());
    for (const std::uint32_t run : tested_) {
      check_unchanged(*dataset_, run);
      const DatasetRun& names = dataset_->runs()[run];
      const RunFolder folder{dataset_->run_folder(run), names.object, names.run};
      JudgedRun judged{
          .run = name_of(names), .object = names.object, .samples = {}, .truth = {}, .guard = dataset_->sampling().guard};
      for (const std::uint32_t sample : samples_of_runs(*dataset_, {&run, 1}))
        judged.samples.push_back(dataset_->samples()[sample]);
      judged.truth = read_run_truth(folder, member<bool>(dataset_->settings(), "include_flagged", dataset_->file().string()));
      judged_.push_back(std::move(judged));
      recordings_.push_back(folder.events());
    }
  }

  std::vector<std::string> tested_names() const { return names_of(*dataset_, tested_); }

  // --- networks

  TradeNetwork network_of(const TradeSetting& setting, unsigned place) const {
    TradeNetwork network;
    network.settings.rendering = setting.rendering;
    // The network sees heatmaps and no ticks: it is trained at the dataset's, or at one that both have.
    const microseconds own = dataset_->sampling().tick, history = setting.rendering.history;
    network.settings.rendering.tick =
        history % own == microseconds{0} ? own : microseconds{std::gcd(own.count(), setting.rendering.history.count())};
    network.settings.training.seed = options_.seed + place;
    network.settings.training.epochs = options_.epochs;
    network.settings.split.train_run = options_.train_run;
    network.bundle = {options_.models / default_name(network.settings)};
    return network;
  }

  Step training_of(const TradeNetwork& network) const {
    return training_step(*dataset_, network.settings, network.bundle,
                         {options_.data, options_.models, from_trade(options_.models)});
  }

  double seconds_of_a_training() const {
    double longest = 0;
    for (const StepRecord& record : runner_.records()) {
      if (record.name.starts_with("train-")) longest = std::max(longest, record.seconds);
    }
    return longest;
  }

  bool budget_allows_a_batch() const {
    if (!options_.budget_minutes) return true;
    const double passed = std::chrono::duration<double>(Clock::now() - begun_).count();
    return passed + seconds_of_a_training() < 60 * *options_.budget_minutes;
  }

  /// Trains those that the budget allows, in their order.
  void train(const std::vector<TradeNetwork>& networks) {
    std::vector<Step> there;
    std::vector<const TradeNetwork*> due;
    std::set<std::string> seen = trained_;
    for (const TradeNetwork& network : networks) {
      if (!seen.insert(network.name()).second) continue;
      if (state_of(network.bundle, *dataset_, network.settings) == BundleState::unchanged) {
        there.push_back(training_of(network));
        trained_.insert(network.name());
      } else {
        due.push_back(&network);
      }
    }
    runner_.run_side_by_side(there);
    const std::size_t at_once = options_.budget_minutes ? threads_ : std::max<std::size_t>(due.size(), 1);
    for (std::size_t begin = 0; begin < due.size() && budget_allows_a_batch(); begin += at_once) {
      std::vector<Step> batch;
      for (std::size_t i = begin; i < std::min(begin + at_once, due.size()); ++i) {
        batch.push_back(training_of(*due[i]));
        trained_.insert(due[i]->name());
      }
      runner_.run_side_by_side(batch);
    }
  }

  // --- points

  void add(const TradeSetting& setting, const std::string& design) {
    const auto is_same = [&](const TradePoint& point) { return point.setting == setting; };
    if (std::any_of(points_.begin(), points_.end(), is_same)) return;
    points_.push_back({.setting = setting, .design = design});
  }

  /// Everything of all points that there are; those that cannot be measured leave.
  void measure(const std::string& times_name) {
    drop_what_the_dataset_cannot_render();
    std::vector<TradeNetwork> networks;
    for (const TradePoint& point : points_) networks.push_back(network_of(point.setting, 0));
    train(networks);
    take_networks();
    if (!points_.empty() && points_.front().networks.empty())
      throw Error("the usual setting could not be measured; expected a larger --budget-minutes");
    drop_unless([](const TradePoint& point) { return !point.networks.empty(); },
                fmt::format("the budget of {:g} minutes was used up before its network was trained",
                            options_.budget_minutes.value_or(0)));
    drop_unless(
        [](const TradePoint& point) {
          return !point.setting.gate || read_description(point.networks.front().bundle).gate.has_value();
        },
        "its network was made without a gate");
    if (points_.empty() || !(points_.front().setting == options_.usual))
      throw Error("the usual setting has a gate, and its network none; expected one that this version of 'tactile train' made");
    for (const TradePoint& point : points_) say(point);
    measure_times(times_name);
    judge();
  }

  void drop_what_the_dataset_cannot_render() {
    std::map<std::string, std::string> why;
    for (const TradePoint& point : points_) {
      try {
        check_renders(*dataset_, network_of(point.setting, 0).settings.rendering);
        check(point.setting.rendering);
        const microseconds said_at = tick_said_at(network_of(point.setting, 0), point.setting.rendering.tick);
        if (said_at < shortest_tick_said) {
          throw Error(fmt::format("its tick and the network's have only {} us in common; expected {} us at least",
                                  said_at.count(), shortest_tick_said.count()));
        }
      } catch (const Error& e) {
        if (point.setting == options_.usual) throw;
        why[id_of(point.setting)] = e.what();
      }
    }
    for (const auto& [id, text] : why) {
      drop_unless([&, &id = id](const TradePoint& point) { return id_of(point.setting) != id; }, text);
    }
  }

  template <class Stays>
  void drop_unless(Stays stays, const std::string& why) {
    for (const TradePoint& point : points_) {
      if (!stays(point)) not_measured_.push_back({text_of(point.setting, options_.usual), why});
    }
    std::erase_if(points_, [&](const TradePoint& point) { return !stays(point); });
  }

  /// Gives each point all seeds of its network that are trained.
  void take_networks() {
    for (TradePoint& point : points_) {
      point.networks.clear();
      for (unsigned place = 0; place < options_.seeds; ++place) {
        TradeNetwork network = network_of(point.setting, place);
        if (!trained_.contains(network.name())) break;
        point.networks.push_back(std::move(network));
      }
    }
  }

  // --- what networks say

  static microseconds tick_said_at(const TradeNetwork& network, microseconds tick) {
    const microseconds own = network.settings.rendering.tick;
    return tick % own == microseconds{0} ? own : microseconds{std::gcd(tick.count(), own.count())};
  }

  static std::string said_name(const TradeNetwork& network, const TradeSetting& setting) {
    return fmt::format("said-{}-{}us-{}-{}", network.name(), tick_said_at(network, setting.rendering.tick).count(),
                       name_of(setting.engine), name_of(setting.precision));
  }

  void say(const TradePoint& point) {
    for (const TradeNetwork& network : point.networks) {
      const std::string name = said_name(network, point.setting);
      if (said_.contains(name)) continue;
      const fs::path file = options_.out / "said" / (name + ".json");
      const microseconds tick = tick_said_at(network, point.setting.rendering.tick);
      runner_.run({.name = name,
                   .command = "",
                   .inputs = {{"manifest", dataset_->manifest_hash()},
                              {"weights", read_description(network.bundle).weights_sha256},
                              {"runs", tested_names()},
                              {"tick_us", tick.count()},
                              {"engine", name_of(point.setting.engine)},
                              {"precision", name_of(point.setting.precision)}},
                   .outputs = [file] { return hash_of_file(file); },
                   .work =
                       [&](const ProgressCallback& progress) {
                         write_said(file, said_anew(network, point.setting, tick, tested_, progress));
                       }});
      said_[name] = read_said(file);
    }
  }

  std::vector<RunSaid> said_anew(const TradeNetwork& network, const TradeSetting& setting, microseconds tick,
                                 std::span<const std::uint32_t> runs, const ProgressCallback& progress) const {
    const Classifier classifier(network.bundle.folder, 1, setting.engine, {.precision = setting.precision});
    std::vector<RunSaid> said(runs.size());
    std::mutex one_at_a_time;
    std::size_t done = 0;
    parallel_for(runs.size(), threads_, [&](std::size_t i) {
      said[i] =
          said_in_run(dataset_->run_folder(runs[i]) / "events.aedat4", name_of(dataset_->runs()[runs[i]]), classifier, tick);
      const std::scoped_lock lock(one_at_a_time);
      tell(progress, ++done, runs.size(), fmt::format("every tick of {}, by {}", said[i].run, network.name()));
    });
    return said;
  }

  // --- what ticks take

  TimedWay way_of(const TradePoint& point) const {
    const TradeSetting& setting = point.setting;
    return {setting.rendering, setting.engine, setting.precision, setting.sparse, point.networks.front().bundle.folder};
  }

  void measure_times(const std::string& name) {
    ways_.clear();
    for (const TradePoint& point : points_) {
      const TimedWay way = way_of(point);
      if (std::find(ways_.begin(), ways_.end(), way) == ways_.end()) ways_.push_back(way);
    }
    const fs::path file = options_.out / "times" / (name + ".json");
    json ways = json::array();
    for (const TimedWay& way : ways_) ways.push_back(json_of(way));
    runner_.run({.name = name,
                 .command = "",
                 .inputs = {{"manifest", dataset_->manifest_hash()},
                            {"runs", tested_names()},
                            {"ways", ways},
                            {"machine", cpu_name()},
                            {"revision", revision()},
                            {"pieces", options_.timing.pieces},
                            {"ticks", options_.timing.ticks},
                            {"turns", options_.timing.turns}},
                 .outputs = [file] { return hash_of_file(file); },
                 .work =
                     [&](const ProgressCallback& progress) {
                       write_times(file, time_ticks(ways_, recordings_, options_.timing, progress));
                     }});
    times_ = read_times(file);
    if (times_.size() != ways_.size()) throw Error(file.string() + ": times of other ways; expected those asked for");
  }

  // --- figures

  static std::optional<std::uint64_t> gate_of(const TradeSetting& setting, const TradeNetwork& network) {
    if (!setting.gate) return std::nullopt;
    return gate_limit(network.bundle, read_description(network.bundle));
  }

  static void add_times(TradedRun& outcome, const std::vector<TickTime>& times, std::optional<std::uint64_t> gate) {
    for (const TickTime& time : times) {
      outcome.tick_us.push_back(time.total(gate));
      if (!gate || time.events >= *gate) outcome.open_tick_us.push_back(time.total({}));
    }
  }

  /// Of every tested run, the first seeds together.
  std::vector<TradedRun> outcomes_of(const TradePoint& point, std::size_t seeds) const {
    std::vector<TradedRun> outcomes(tested_.size());
    for (std::size_t seed = 0; seed < seeds; ++seed) {
      const TradeNetwork& network = point.networks[seed];
      const auto gate = gate_of(point.setting, network);
      const std::vector<RunSaid>& said = said_.at(said_name(network, point.setting));
      for (std::size_t run = 0; run < tested_.size(); ++run) {
        const RunSaid at_its_tick = at_tick(said[run], point.setting.rendering.tick);
        const TradedRun outcome =
            outcome_of(judged_[run], at_its_tick, verdicts_of(at_its_tick, gate, point.setting.confirmation));
        if (seed == 0) {
          outcomes[run] = outcome;
        } else {
          outcomes[run] += outcome;
        }
      }
    }
    const auto way = static_cast<std::size_t>(std::find(ways_.begin(), ways_.end(), way_of(point)) - ways_.begin());
    const auto gate = gate_of(point.setting, point.networks.front());
    for (std::size_t run = 0; run < tested_.size(); ++run) add_times(outcomes[run], times_[way].at(run), gate);
    return outcomes;
  }

  void judge() {
    std::vector<std::vector<TradedRun>> usual{{}};  // by its first seeds
    for (std::size_t seeds = 1; seeds <= points_.front().networks.size(); ++seeds)
      usual.push_back(outcomes_of(points_.front(), seeds));
    parallel_for(points_.size(), threads_, [&](std::size_t i) {
      TradePoint& point = points_[i];
      const std::vector<TradedRun> outcomes = outcomes_of(point, point.networks.size());
      const std::span<const TradedRun> all(outcomes);
      point.choice = result_of(all.first(choice_count_));
      point.reported = result_of(all.subspan(choice_count_));
      point.choice.figures.tick_us = point.reported.figures.tick_us = static_cast<double>(point.setting.rendering.tick.count());
      point.difference.reset();
      if (i == 0) return;
      // With as many seeds of each, so that the runs are paired.
      const std::size_t seeds = std::min(point.networks.size(), points_.front().networks.size());
      const std::vector<TradedRun> same = seeds < point.networks.size() ? outcomes_of(point, seeds) : outcomes;
      point.difference = difference_of(std::span(usual[seeds]).subspan(choice_count_), std::span(same).subspan(choice_count_));
    });
    find_fronts();
  }

  void find_fronts() {
    std::vector<TradePlace> by_accuracy, by_delay;
    for (TradePoint& point : points_) {
      point.on_accuracy_front = point.on_delay_front = false;
      const TradeFigures& figures = point.choice.figures;
      by_accuracy.push_back({figures.us_p99.value, -figures.accuracy.value, 0});
      by_delay.push_back({figures.false_alarms_per_min.value, figures.delay_us.value, point.choice.missed.value});
    }
    for (const std::size_t i : pareto_front(by_accuracy)) points_[i].on_accuracy_front = true;
    for (const std::size_t i : pareto_front(by_delay)) points_[i].on_delay_front = true;
  }

  std::map<std::string, TradeOutcome> outcomes() const {
    std::map<std::string, TradeOutcome> all;
    for (const TradePoint& point : points_) {
      const TradeFigures& figures = point.choice.figures;
      const TradeOutcome outcome{figures.accuracy.value, figures.us_p99.value, figures.delay_us.value,
                                 figures.false_alarms_per_min.value, point.choice.missed.value};
      const bool is_known = std::isfinite(outcome.accuracy) && std::isfinite(outcome.us) && std::isfinite(outcome.delay_us) &&
                            std::isfinite(outcome.false_alarms_per_min);
      if (is_known) all[id_of(point.setting)] = outcome;
    }
    return all;
  }

  /// Trains the networks of the front, and the usual one, with the other seeds too, until the front has no others.
  void sow_the_front() {
    for (;;) {  // to an end: there are only so many networks
      std::vector<TradeNetwork> networks;
      for (const TradePoint& point : points_) {
        if (!point.on_accuracy_front && !point.on_delay_front && &point != &points_.front()) continue;
        for (unsigned place = 1; place < options_.seeds; ++place) networks.push_back(network_of(point.setting, place));
      }
      const std::size_t before = trained_.size();
      train(networks);
      if (trained_.size() == before) return;
      take_networks();
      for (const TradePoint& point : points_) say(point);
      judge();
    }
  }

  // --- how cost grows

  void measure_cost_growth() {
    const fs::path file = options_.out / "growth.json";
    std::vector<fs::path> recordings;
    for (const std::uint32_t run : train_runs_) recordings.push_back(dataset_->run_folder(run) / "events.aedat4");
    if (recordings.size() > 3) recordings.resize(3);  // events enough
    const GrowthOptions& growth = options_.growth_options;
    json histories = json::array(), sensors = json::array();
    for (const microseconds history : growth.histories) histories.push_back(history.count());
    for (const SensorSize& sensor : growth.sensors) sensors.push_back({sensor.width, sensor.height});
    runner_.run({.name = "growth",
                 .command = "",
                 .inputs = {{"manifest", dataset_->manifest_hash()},
                            {"machine", cpu_name()},
                            {"revision", revision()},
                            {"rates", growth.rates},
                            {"histories_us", histories},
                            {"sensors", sensors},
                            {"usual_rate", growth.usual_rate},
                            {"pieces", growth.pieces},
                            {"ticks", growth.ticks},
                            {"turns", growth.turns}},
                 .outputs = [file] { return hash_of_file(file); },
                 .work =
                     [&](const ProgressCallback& progress) {
                       write_json(file, measure_growth(moving_events(recordings), dataset_->sensor(), growth, progress));
                     }});
    growth_ = read_json(file);
  }

  // --- the recommendation

  void recommend_one() {
    const TradeWish& wish = options_.wish;
    recommendation_ = {{"wish", wish},    {"setting", nullptr}, {"id", nullptr}, {"met", false}, {"chosen_in_interval", nullptr},
                       {"again", nullptr}};
    std::vector<TradeFigures> candidates;
    for (const TradePoint& point : points_) {
      candidates.push_back(point.choice.figures);
      if (!point.setting.sparse) candidates.back().accuracy = {};  // no detector has it: it is there to compare with
    }
    const auto choice = wish.any() ? choose(wish, candidates) : std::nullopt;
    Recommendation recommendation;
    if (choice) {
      const TradePoint& point = points_[choice->index];
      const json again = measured_again(point);
      TradeFigures figures;
      const std::string where = (options_.out / "again").string();
      figures.accuracy = figure_in(again.at("accuracy"), where);
      figures.us_p50 = figure_in(again.at("us").at("p50"), where);
      figures.us_p99 = figure_in(again.at("us").at("p99"), where);
      figures.delay_us = figure_in(again.at("delay_us").at("mean"), where);
      figures.false_alarms_per_min = figure_in(again.at("false_alarms_per_min"), where);
      figures.tick_us = point.choice.figures.tick_us;
      const std::string words = &point == &points_.front() ? "the usual setting (" + whole_text(point.setting) + ")"
                                                           : text_of(point.setting, options_.usual) + " (else as usual)";
      recommendation = recommend(wish, words, figures, dataset_->simulated());
      recommendation_["setting"] = point.setting;
      recommendation_["id"] = id_of(point.setting);
      recommendation_["model"] = point.networks.front().name();
      recommendation_["chosen_in_interval"] = choice->in_interval;
      recommendation_["again"] = again;
    } else {
      recommendation = recommend(wish, std::nullopt, {}, dataset_->simulated());
    }
    recommendation_["met"] = recommendation.met;
    recommendation_["sentence"] = recommendation.sentence;
  }

  static std::string whole_text(const TradeSetting& setting) {
    TradeSetting named;
    named.rendering.history = setting.rendering.history;
    named.rendering.tick = setting.rendering.tick;
    named.rendering.factor = setting.rendering.factor;
    return fmt::format("t_h {:g} ms, tick {:g} ms, factor {:g}{}", in_ms(setting.rendering.history),
                       in_ms(setting.rendering.tick), setting.rendering.factor,
                       setting == named ? "" : ", " + text_of(setting, named));
  }

  /// The first seed's network on the reported runs: nothing of what was kept is used.
  json measured_again(const TradePoint& point) {
    const TradeNetwork& network = point.networks.front();
    const fs::path file = options_.out / "again" / (id_of(point.setting) + ".json");
    const std::span<const std::uint32_t> reported = std::span(tested_).subspan(choice_count_);
    runner_.run({.name = "again-" + id_of(point.setting),
                 .command = "",
                 .inputs = {{"manifest", dataset_->manifest_hash()},
                            {"weights", read_description(network.bundle).weights_sha256},
                            {"setting", point.setting},
                            {"runs", names_of(*dataset_, reported)},
                            {"truth", truth_hashes(reported)},
                            {"machine", cpu_name()},
                            {"revision", revision()}},
                 .outputs = [file] { return hash_of_file(file); },
                 .work = [&](const ProgressCallback& progress) { write_json(file, again(point, reported, progress)); }});
    return read_json(file);
  }

  json truth_hashes(std::span<const std::uint32_t> runs) const {
    json hashes = json::array();
    for (const std::uint32_t run : runs) hashes.push_back(hash_of_file(dataset_->run_folder(run) / "truth.json"));
    return hashes;
  }

  json again(const TradePoint& point, std::span<const std::uint32_t> reported, const ProgressCallback& progress) const {
    const TradeSetting& setting = point.setting;
    const TradeNetwork& network = point.networks.front();
    const auto gate = gate_of(setting, network);
    const std::vector<TimedWay> ways{way_of(points_.front()), way_of(point)};
    const auto times = time_ticks(ways, std::span(recordings_).subspan(choice_count_), options_.timing, progress);
    const auto said = said_anew(network, setting, setting.rendering.tick, reported, progress);
    std::vector<TradedRun> outcomes;
    for (std::size_t i = 0; i < reported.size(); ++i) {
      outcomes.push_back(outcome_of(judged_[choice_count_ + i], said[i], verdicts_of(said[i], gate, setting.confirmation)));
      add_times(outcomes.back(), times[1].at(i), gate);
    }
    const TradeResult counted = result_of(outcomes);
    json result = counted;
    result["by"] = "trade";
    // `eval` judges at the network's own ticks alone, where samples lie.
    if (setting.rendering.tick == network.settings.rendering.tick) {
      const Classifier classifier(network.bundle.folder, threads_, setting.engine, {.precision = setting.precision});
      const Evaluation evaluation =
          evaluate(*dataset_, classifier, reported,
                   {.confirmation = setting.confirmation, .gate = setting.gate, .threads = threads_}, progress);
      result["by"] = "eval";
      result["accuracy"] = evaluation.accuracy.mean;
      result["false_alarms_per_min"] = evaluation.network.false_alarms.per_min;
    }
    result["model"] = network.name();
    result["runs"] = names_of(*dataset_, reported);
    return result;
  }

  // --- results

  std::string from_trade(const fs::path& path) const {
    const auto whole = [](const fs::path& any) { return fs::weakly_canonical(fs::absolute(any)); };
    return whole(path).lexically_relative(whole(options_.out)).generic_string();
  }

  json point_json(const TradePoint& point) const {
    json networks = json::array();
    for (const TradeNetwork& network : point.networks) networks.push_back(network.name());
    json entry = {
        {"id", id_of(point.setting)}, {"text", text_of(point.setting, options_.usual)},
        {"design", point.design},     {"setting", point.setting},
        {"models", networks},         {"seeds", point.networks.size()},
        {"choice", point.choice},     {"reported", point.reported},
        {"difference", nullptr},      {"front", {{"accuracy", point.on_accuracy_front}, {"delay", point.on_delay_front}}}};
    if (point.difference) entry["difference"] = *point.difference;
    return entry;
  }

  /// Of how many settings the time that 99 of 100 ticks do not exceed is uncertain by more than a factor of four: the longest
  /// heatmap of a run takes some twice as long as its usual one, all else is what the machine did meanwhile.
  std::size_t settings_on_a_busy_machine() const {
    return static_cast<std::size_t>(std::count_if(points_.begin(), points_.end(), [](const TradePoint& point) {
      const auto is_uncertain = [](const Figure& us) { return us.low && us.high && *us.high > 4 * *us.low; };
      return is_uncertain(point.choice.figures.us_p99) || is_uncertain(point.reported.figures.us_p99);
    }));
  }

  json levels_json() const {
    json levels = json::object();
    for (const TradeFactor& factor : factors_of(options_.levels)) {
      levels[factor.name] = json::array();
      for (const TradeLevel& level : factor.levels) levels[factor.name].push_back(level.text);
    }
    return levels;
  }

  json write_results() const {
    const BootstrapOptions bootstrap;
    const std::span<const std::uint32_t> all(tested_);
    json trade = {
        {"format", "tactile-trade-1"},
        {"title", fmt::format("Speed against accuracy on {} runs", dataset_->simulated() ? "simulated" : "real")},
        {"simulated", dataset_->simulated()},
        {"times_are",
         fmt::format(
             "Time per tick is that of computing: counting events, rendering and network, on one thread of one process, at {} "
             "times of every run, the median of {} turns, in which all settings come one after the other, so that what else "
             "the machine does falls on all alike. What 'tactile detect' waits for beside it, it tells itself.",
             options_.timing.ticks * options_.timing.pieces, options_.timing.turns)},
        {"settings",
         {{"data", from_trade(options_.data)},
          {"models", from_trade(options_.models)},
          {"train_run", options_.train_run},
          {"choice_runs", options_.choice_runs},
          {"epochs", options_.epochs},
          {"seeds", options_.seeds},
          {"seed", options_.seed},
          {"full", options_.full},
          {"budget_minutes", options_.budget_minutes ? json(*options_.budget_minutes) : json()},
          {"levels", levels_json()}}},
        {"software", {{"name", "tactile"}, {"version", version()}, {"revision", revision()}, {"libtorch", torch_version()}}},
        {"machine",
         {{"cpu", cpu_name()},
          {"system", system_name()},
          {"cores", std::thread::hardware_concurrency()},
          {"memory_bytes", memory_bytes()},
          {"threads", threads_}}},
        {"bootstrap", {{"draws", bootstrap.draws}, {"confidence", bootstrap.confidence}, {"seed", bootstrap.seed}}},
        {"dataset",
         {{"file", from_trade(dataset_->file())},
          {"manifest_hash", dataset_->manifest_hash()},
          {"samples", dataset_->samples().size()}}},
        {"runs",
         {{"train", names_of(*dataset_, train_runs_)},
          {"choice", names_of(*dataset_, all.first(choice_count_))},
          {"reported", names_of(*dataset_, all.subspan(choice_count_))}}},
        {"usual", id_of(options_.usual)},
        {"busy", settings_on_a_busy_machine()},
        {"points", json::array()},
        {"left_out", json::array()},
        {"not_measured", json::array()},
        {"growth", growth_},
        {"recommendation", recommendation_},
        {"steps", json::array()}};
    for (const TradePoint& point : points_) trade["points"].push_back(point_json(point));
    for (const LeftOutPair& pair : left_out_pairs(options_.levels)) {
      trade["left_out"].push_back(
          {{"th_ms", in_ms(pair.history)}, {"tick_ms", in_ms(pair.tick)}, {"why", "the history is no whole number of ticks"}});
    }
    for (const TradePoint& point : points_) {
      if ((point.on_accuracy_front || point.on_delay_front) && point.networks.size() < options_.seeds)
        trade["not_measured"].push_back({{"setting", text_of(point.setting, options_.usual)},
                                         {"why", fmt::format("with {} of {} seeds: the budget was used up",
                                                             options_.seeds - point.networks.size(), options_.seeds)}});
    }
    for (const NotMeasured& one : not_measured_) trade["not_measured"].push_back({{"setting", one.setting}, {"why", one.why}});
    for (const StepRecord& record : runner_.records()) {
      trade["steps"].push_back({{"name", record.name},
                                {"command", record.command.empty() ? json() : json(record.command)},
                                {"seconds", record.seconds},
                                {"finished_at", record.finished_at}});
    }
    write_whole(options_.out / "trade.csv", trade_csv(trade));
    write_whole(options_.out / "trade.json", trade.dump(2) + "\n");
    return trade;
  }

  TradeOptions options_;
  unsigned threads_;
  Clock::time_point begun_;
  FolderLock lock_;
  StepRunner runner_;
  const Dataset* dataset_ = nullptr;

  std::vector<std::uint32_t> train_runs_;
  std::vector<std::uint32_t> tested_;  ///< runs to choose on, then those to report on
  std::size_t choice_count_ = 0;
  std::vector<JudgedRun> judged_;     ///< of each of them
  std::vector<fs::path> recordings_;  ///< likewise
  std::set<std::string> trained_;     ///< names of networks
  std::map<std::string, std::vector<RunSaid>> said_;
  std::vector<TradePoint> points_;  ///< the usual one first
  std::vector<NotMeasured> not_measured_;
  std::vector<TimedWay> ways_;
  std::vector<TimesOfRuns> times_;  ///< of each way
  json growth_, recommendation_;
};

void check_options(const TradeOptions& options) {
  if (options.seeds == 0) throw Error("no seed to train with; expected one at least");
  if (const auto why = why_impossible(options.usual)) throw Error("the usual setting is impossible: " + *why);
  const TradeLevels& levels = options.levels;
  for (const auto* times : {&levels.histories, &levels.ticks}) {
    for (const microseconds time : *times) {
      if (time <= microseconds{0}) throw Error("a history or a tick of 0 us; expected more");
    }
  }
}

}  // namespace

TradeSummary run_trade(const TradeOptions& options, const NewProgress& new_progress,
                       const std::function<void(const std::string& step, bool kept)>& tell) {
  check_options(options);
  return Trade(options, new_progress, tell).run();
}

std::string trade_csv(const json& trade) {
  std::string csv =
      "id,design,seeds,th_ms,tick_ms,factor,resize,denoise,engine,precision,pass,confirm,gate,runs,"
      "accuracy,accuracy_low,accuracy_high,delay_us,delay_us_low,delay_us_high,delay_p95_us,missed,"
      "false_alarms_per_min,false_alarms_per_min_low,false_alarms_per_min_high,us_p50,us_p50_low,us_p50_high,"
      "us_p99,us_p99_low,us_p99_high,front_accuracy,front_delay\n";
  const auto number = [](const json& value) {
    return value.is_null() ? std::string() : fmt::format("{:.9g}", value.get<double>());
  };
  const auto figure = [&](const json& value) {
    return fmt::format("{},{},{}", number(value.at("value")), number(value.at("low")), number(value.at("high")));
  };
  for (const json& point : trade.at("points")) {
    for (const char* runs : {"choice", "reported"}) {
      const json &setting = point.at("setting"), &result = point.at(runs);
      const auto word = [&](const char* key) { return setting.at(key).get<std::string>(); };
      csv += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{},", point.at("id").get<std::string>(),
                         point.at("design").get<std::string>(), point.at("seeds").get<std::size_t>(), number(setting.at("th_ms")),
                         number(setting.at("tick_ms")), number(setting.at("factor")), word("resize"), word("denoise"),
                         word("engine"), word("precision"), word("pass"), word("confirm"),
                         setting.at("gate").get<bool>() ? "on" : "off", runs);
      const json& delay = result.at("delay_us");
      csv += fmt::format("{},{},{},{},{},{},{},{},{}\n", figure(result.at("accuracy")), figure(delay.at("mean")),
                         number(delay.at("p95").at("value")), number(delay.at("missed").at("value")),
                         figure(result.at("false_alarms_per_min")), figure(result.at("us").at("p50")),
                         figure(result.at("us").at("p99")), point.at("front").at("accuracy").get<bool>() ? 1 : 0,
                         point.at("front").at("delay").get<bool>() ? 1 : 0);
    }
  }
  return csv;
}

json detect_config(const json& trade, const fs::path& trade_folder) {
  const json& recommendation = trade.at("recommendation");
  if (recommendation.at("id").is_null() || !recommendation.at("met").get<bool>())
    throw Error("no setting to apply: " + recommendation.at("sentence").get<std::string>());
  const json& setting = recommendation.at("setting");
  const fs::path models = trade_folder / trade.at("settings").at("models").get<std::string>();
  return {{"model", fs::weakly_canonical(fs::absolute(models / recommendation.at("model").get<std::string>())).string()},
          {"tick-us", static_cast<std::int64_t>(std::llround(1000 * setting.at("tick_ms").get<double>()))},
          {"engine", setting.at("engine")},
          {"precision", setting.at("precision")},
          {"confirm", setting.at("confirm")},
          {"gate", setting.at("gate")}};
}

}  // namespace tactile
