#include "tactile/trade/trade.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
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
#include "tactile/heatmaps/render_samples.hpp"
#include "tactile/model/training/open_classifier.hpp"
#include "tactile/model/training/train_model.hpp"
#include "tactile/study/folder_lock.hpp"
#include "tactile/study/study_json.hpp"
#include "tactile/study/study_runs.hpp"
#include "tactile/study/training_step.hpp"
#include "tactile/trade/full_runs.hpp"
#include "tactile/trade/measured_again.hpp"
#include "tactile/trade/pareto_front.hpp"
#include "tactile/trade/trade_figures.hpp"
#include "tactile/trade/trade_point.hpp"
#include "tactile/trade/trade_results.hpp"

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
                 .tell = [this, tell](const std::string& step, bool kept) {
                   if (!tell) return;
                   // A part is told of once something of it is to be done.
                   if (!kept && !part_.empty()) tell(std::exchange(part_, {}), false);
                   tell(step, kept);
                 }}) {}

  TradeSummary run() {
    const Dataset dataset(options_.data / "dataset.h5");
    dataset_ = &dataset;
    divide_runs();
    const auto design =
        options_.full ? all_combinations(options_.usual, options_.levels) : one_at_a_time(options_.usual, options_.levels);
    // The usual setting first: all others are told by their difference to it.
    add(options_.usual, "usual");
    for (const TradeSetting& setting : design) add(setting, options_.full ? "all" : "one");
    begin_part(fmt::format("{}, {} settings", options_.full ? "every combination" : "one knob at a time", points_.size()));
    measure("times-design");
    if (!options_.full) {
      const std::size_t before = points_.size();
      for (const TradeSetting& corner : promising_corners(options_.usual, options_.levels, outcomes(), options_.corners))
        add(corner, "corner");
      begin_part(fmt::format("{} combinations that look promising", points_.size() - before));
      if (points_.size() > before) measure("times");
    }
    if (options_.seeds > 1) begin_part(fmt::format("what lies on a front and the usual setting with {} seeds", options_.seeds));
    sow_the_front();
    if (options_.growth) {
      begin_part("how the cost of a tick grows");
      measure_cost_growth();
    }
    if (options_.wish.any()) begin_part("a setting for what is wished");
    recommend_one();
    TradeSummary summary;
    summary.trade = write_results();
    summary.file = options_.out / "trade.json";
    summary.done = runner_.done_now();
    summary.kept = runner_.records().size() - runner_.done_now();
    return summary;
  }

 private:
  // --- what is told of it

  /// Told once a step of it is done: parts that are kept are not worth a word.
  void begin_part(const std::string& words) {
    const int parts =
        1 + (options_.full ? 0 : 1) + (options_.seeds > 1 ? 1 : 0) + (options_.growth ? 1 : 0) + (options_.wish.any() ? 1 : 0);
    part_ = fmt::format("part {} of {}: {}", ++parts_begun_, parts, words);
  }

  /// A network by what is other than usual, where `rendering` is its own, at the tick that it is asked at.
  std::string words_of(const TradeNetwork& network, microseconds tick, EngineKind engine, Precision precision) const {
    TradeSetting asked = options_.usual, usual = options_.usual;
    asked.rendering = network.settings.rendering;
    asked.rendering.tick = tick;
    asked.engine = engine, asked.precision = precision;
    usual.rendering.tick = tick_said_at(network_of(options_.usual, 0), options_.usual.rendering.tick);
    const std::string words = asked == usual ? "the usual network" : text_of(asked, usual);
    return options_.seeds > 1 ? fmt::format("{}, seed {}", words, network.settings.training.seed) : words;
  }

  std::string words_of(const TradeNetwork& network) const {
    const microseconds usual_tick = tick_said_at(network_of(options_.usual, 0), options_.usual.rendering.tick);
    return words_of(network, usual_tick, options_.usual.engine, options_.usual.precision);
  }

  /// What is left of steps that take alike, by those done since.
  static std::string time_left(Clock::time_point begun, std::size_t done, std::size_t all) {
    if (done == 0) return {};
    const double passed = std::chrono::duration<double>(Clock::now() - begun).count();
    const double left = passed / static_cast<double>(done) * static_cast<double>(all - done);
    return left < 90 ? fmt::format(", about {:.0f} s left", left) : fmt::format(", about {:.0f} min left", left / 60);
  }

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
    tested_.indexes = runs.choice;
    tested_.indexes.insert(tested_.indexes.end(), runs.reported.begin(), runs.reported.end());
    for (const std::uint32_t run : tested_.indexes) {
      check_unchanged(*dataset_, run);
      const DatasetRun& names = dataset_->runs()[run];
      const RunFolder folder{dataset_->run_folder(run), names.object, names.run};
      JudgedRun judged{
          .run = name_of(names), .object = names.object, .samples = {}, .truth = {}, .guard = dataset_->sampling().guard};
      for (const std::uint32_t sample : samples_of_runs(*dataset_, {&run, 1}))
        judged.samples.push_back(dataset_->samples()[sample]);
      judged.truth = read_run_truth(folder, member<bool>(dataset_->settings(), "include_flagged", dataset_->file().string()));
      tested_.judged.push_back(std::move(judged));
      tested_.recordings.push_back(folder.events());
    }
  }

  std::vector<std::string> tested_names() const { return names_of(*dataset_, tested_.indexes); }

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
                         {options_.data, options_.models, from_folder(options_.models, options_.out)});
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
    for (std::size_t begin = 0; begin < due.size(); begin += at_once) {
      if (!budget_allows_a_batch()) {
        budget_ended_ = true;
        return;
      }
      std::vector<Step> batch;
      for (std::size_t i = begin; i < std::min(begin + at_once, due.size()); ++i) {
        batch.push_back(training_of(*due[i]));
        batch.back().words = fmt::format("training {} of {}: {}", i + 1, due.size(), words_of(*due[i]));
        trained_.insert(due[i]->name());
      }
      trainings_begun_ += batch.size();
      runner_.run_side_by_side(batch);
    }
  }

  /// Where the budget ended the work, whether the next call goes on, and what it needs for it.
  std::string unfinished() const {
    if (!budget_ended_) return {};
    const double minutes = options_.budget_minutes.value_or(0), training = seconds_of_a_training() / 60;
    if (trainings_begun_ > 0 && training < minutes) {
      return fmt::format(
          "The budget of {:g} minutes ended the work: run the same command again, and it goes on where it stopped; all that is "
          "done is kept.",
          minutes);
    }
    return fmt::format(
        "The budget of {:g} minutes ended the work, and leaves no room for a training{}: run the same command with a larger "
        "--budget-minutes, and it goes on where it stopped; all that is done is kept.",
        minutes, training > 0 ? fmt::format(" of {:.2g} minutes", training) : std::string());
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
      throw Error("the usual setting's network is not trained yet; expected time for it. " + unfinished());
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
    say_all();
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

  Step saying_of(const TradeNetwork& network, const TradeSetting& setting) const {
    const fs::path file = options_.out / "said" / (said_name(network, setting) + ".json");
    const microseconds tick = tick_said_at(network, setting.rendering.tick);
    return {.name = said_name(network, setting),
            .command = "",
            .inputs = {{"manifest", dataset_->manifest_hash()},
                       {"weights", read_description(network.bundle).weights_sha256},
                       {"runs", tested_names()},
                       {"tick_us", tick.count()},
                       {"engine", name_of(setting.engine)},
                       {"precision", name_of(setting.precision)}},
            .outputs = [file] { return hash_of_file(file); },
            .work =
                [this, file, tick, network, setting](const ProgressCallback& progress) {
                  const Classifier classifier =
                      open_classifier(network.bundle.folder, 1, setting.engine, {.precision = setting.precision});
                  write_full_runs(file, classify_full_runs(*dataset_, tested_.indexes, classifier, tick, threads_, progress));
                }};
  }

  /// What all networks of all points say.
  void say_all() {
    std::vector<Step> due;
    const auto take = [this](const std::string& name) { said_[name] = read_full_runs(options_.out / "said" / (name + ".json")); };
    std::set<std::string> seen;
    for (const TradePoint& point : points_) {
      for (const TradeNetwork& network : point.networks) {
        const std::string name = said_name(network, point.setting);
        if (said_.contains(name) || !seen.insert(name).second) continue;
        Step step = saying_of(network, point.setting);
        step.words =
            words_of(network, tick_said_at(network, point.setting.rendering.tick), point.setting.engine, point.setting.precision);
        if (!runner_.is_done(step)) {
          due.push_back(std::move(step));
          continue;
        }
        runner_.run(step);
        take(name);
      }
    }
    const Clock::time_point begun = Clock::now();
    for (std::size_t i = 0; i < due.size(); ++i) {
      due[i].words = fmt::format("judging {} of {}, at every tick of {} runs: {}{}", i + 1, due.size(), tested_.indexes.size(),
                                 due[i].words, time_left(begun, i, due.size()));
      runner_.run(due[i]);
      take(due[i].name);
    }
  }

  // --- what ticks take

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
                       write_times(file, time_ticks(ways_, tested_.recordings, options_.timing, progress));
                     },
                 .words = fmt::format("timing {} ways to compute a tick, in turns, at {} times of each of {} runs", ways_.size(),
                                      options_.timing.pieces * options_.timing.ticks, tested_.indexes.size())});
    times_ = read_times(file);
    if (times_.size() != ways_.size()) throw Error(file.string() + ": times of other ways; expected those asked for");
  }

  // --- figures

  /// Of every tested run, the first seeds together.
  std::vector<TradedRun> outcomes_of(const TradePoint& point, std::size_t seeds) const {
    std::vector<TradedRun> outcomes(tested_.indexes.size());
    for (std::size_t seed = 0; seed < seeds; ++seed) {
      const TradeNetwork& network = point.networks[seed];
      const auto gate = gate_of(point.setting, network);
      const std::vector<FullRun>& said = said_.at(said_name(network, point.setting));
      for (std::size_t run = 0; run < outcomes.size(); ++run) {
        const FullRun at_its_tick = at_tick(said[run], point.setting.rendering.tick);
        const TradedRun outcome =
            outcome_of(tested_.judged[run], at_its_tick, verdicts_of(at_its_tick, gate, point.setting.confirmation));
        if (seed == 0) {
          outcomes[run] = outcome;
        } else {
          outcomes[run] += outcome;
        }
      }
    }
    const auto way = static_cast<std::size_t>(std::find(ways_.begin(), ways_.end(), way_of(point)) - ways_.begin());
    const auto gate = gate_of(point.setting, point.networks.front());
    for (std::size_t run = 0; run < outcomes.size(); ++run) add_times(outcomes[run], times_[way].at(run), gate);
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
      say_all();
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
                     },
                 .words = fmt::format("timing ticks at {} event rates, {} histories and {} sensor sizes", growth.rates.size(),
                                      growth.histories.size(), growth.sensors.size())});
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
      const JsonView view(again, (options_.out / "again").string(), MissingMember::is_error);
      figures.accuracy = view["accuracy"].get<Figure>();
      figures.us_p50 = view["us"]["p50"].get<Figure>();
      figures.us_p99 = view["us"]["p99"].get<Figure>();
      figures.delay_us = view["delay_us"]["mean"].get<Figure>();
      figures.false_alarms_per_min = view["false_alarms_per_min"].get<Figure>();
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
    const TestedRuns reported = tested_.from(choice_count_);
    runner_.run({.name = "again-" + id_of(point.setting),
                 .command = "",
                 .inputs = {{"manifest", dataset_->manifest_hash()},
                            {"weights", read_description(network.bundle).weights_sha256},
                            {"setting", point.setting},
                            {"runs", names_of(*dataset_, reported.indexes)},
                            {"truth", truth_hashes(reported.indexes)},
                            {"machine", cpu_name()},
                            {"revision", revision()}},
                 .outputs = [file] { return hash_of_file(file); },
                 .work =
                     [&](const ProgressCallback& progress) {
                       write_json(
                           file, measure_again(point, points_.front(), *dataset_, reported, options_.timing, threads_, progress));
                     },
                 .words = fmt::format("measuring the setting chosen again, on {} runs that it was not chosen on: {}",
                                      reported.indexes.size(), text_of(point.setting, options_.usual))});
    return read_json(file);
  }

  json truth_hashes(std::span<const std::uint32_t> runs) const {
    json hashes = json::array();
    for (const std::uint32_t run : runs) hashes.push_back(hash_of_file(dataset_->run_folder(run) / "truth.json"));
    return hashes;
  }

  json write_results() const {
    const std::span<const std::uint32_t> all(tested_.indexes);
    const json trade = trade_json({.options = options_,
                                   .dataset = *dataset_,
                                   .threads = threads_,
                                   .train = train_runs_,
                                   .choice = all.first(choice_count_),
                                   .reported = all.subspan(choice_count_),
                                   .points = points_,
                                   .not_measured = not_measured_,
                                   .growth = growth_,
                                   .recommendation = recommendation_,
                                   .unfinished = unfinished(),
                                   .steps = runner_.records()});
    write_trade(trade, options_.out);
    return trade;
  }

  TradeOptions options_;
  unsigned threads_;
  Clock::time_point begun_;
  FolderLock lock_;
  StepRunner runner_;
  const Dataset* dataset_ = nullptr;

  std::vector<std::uint32_t> train_runs_;
  TestedRuns tested_;  ///< runs to choose on, then those to report on
  std::size_t choice_count_ = 0;
  std::set<std::string> trained_;  ///< names of networks
  std::map<std::string, std::vector<FullRun>> said_;
  std::vector<TradePoint> points_;  ///< the usual one first
  std::vector<NotMeasured> not_measured_;
  std::vector<TimedWay> ways_;
  std::vector<TimesOfRuns> times_;  ///< of each way
  json growth_, recommendation_;
  std::string part_;  ///< not told yet
  int parts_begun_ = 0;
  bool budget_ended_ = false;
  std::size_t trainings_begun_ = 0;
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
