#include "tactile/study/study.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <thread>

#include "tactile/core/error.hpp"
#include "tactile/core/json.hpp"
#include "tactile/core/json_text.hpp"
#include "tactile/core/runs_below.hpp"
#include "tactile/core/sha256.hpp"
#include "tactile/core/text_lines.hpp"
#include "tactile/core/whole_file.hpp"
#include "tactile/evaluation/evaluation.hpp"
#include "tactile/evaluation/evaluation_table.hpp"
#include "tactile/evaluation/run_prediction.hpp"
#include "tactile/heatmaps/render_samples.hpp"
#include "tactile/heatmaps/store_heatmaps.hpp"
#include "tactile/labels/label_runs.hpp"
#include "tactile/model/training/open_classifier.hpp"
#include "tactile/model/training/split_remarks.hpp"
#include "tactile/model/training/train_model.hpp"
#include "tactile/simulation/simulate.hpp"
#include "tactile/study/claims.hpp"
#include "tactile/study/folder_lock.hpp"
#include "tactile/study/history_choice.hpp"
#include "tactile/study/leave_five_out.hpp"
#include "tactile/study/left_out.hpp"
#include "tactile/study/sample_verdicts.hpp"
#include "tactile/study/step_runner.hpp"
#include "tactile/study/study_json.hpp"
#include "tactile/study/study_runs.hpp"
#include "tactile/study/training_step.hpp"
#include "tactile/windows/dataset_settings.hpp"
#include "tactile/windows/without_samples.hpp"
#include "tactile/windows/write_dataset.hpp"

namespace tactile {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr microseconds shortest_stored{50'000};  ///< of events before each sample, by windows' default
constexpr int evaluation_form = 2;               ///< another one, and evaluations that are kept are made anew

double in_ms(microseconds us) { return static_cast<double>(us.count()) / 1000; }

std::string joined_ms(std::span<const microseconds> histories) {
  std::vector<std::string> texts;
  for (const microseconds history : histories) texts.push_back(ms_text(history));
  return fmt::format("{}", fmt::join(texts, ","));
}

json size_of(const fs::path& file) {
  std::error_code missing;
  const auto size = fs::file_size(file, missing);
  return missing ? json() : json(size);
}

/// Size and time of change: enough to see that somebody wrote to a file too large to be read each time.
json state_of_file(const fs::path& file) {
  std::error_code missing;
  const auto changed = fs::last_write_time(file, missing);
  return missing ? json() : json::array({size_of(file), changed.time_since_epoch().count()});
}

json hash_of_file(const fs::path& file) { return fs::is_regular_file(file) ? json(sha256_of_file(file)) : json(); }

/// Null if one of them is missing.
json hashes_of(std::initializer_list<fs::path> files) {
  json hashes = json::object();
  for (const fs::path& file : files) {
    const json hash = hash_of_file(file);
    if (hash.is_null()) return {};
    hashes[file.filename().string()] = hash;
  }
  return hashes;
}

std::vector<RunFolder> runs_below(const fs::path& data) { return is_there(data) ? find_runs(data) : std::vector<RunFolder>{}; }

/// A model that the study trains.
struct StudyModel {
  ModelSettings settings;
  ModelBundle bundle;
  std::vector<std::uint32_t> runs;  ///< of the dataset, that its samples are judged on

  std::string name() const { return bundle.name(); }
};

/// One set of runs that figures are told of.
struct RunSet {
  std::string name;  ///< "choice", "reported", "all_test"
  std::vector<std::uint32_t> runs;
  std::vector<std::string> names;
};

class Study {
 public:
  Study(const StudyOptions& options, const NewProgress& new_progress, const std::function<void(const std::string&, bool)>& tell,
        const std::function<void(const std::string&)>& warn)
      : options_(options),
        warn_(warn),
        preset_(preset_settings(options.preset)),
        epochs_(options.epochs.value_or(preset_.epochs)),
        threads_(options.threads > 0 ? options.threads : std::max(1U, std::thread::hardware_concurrency())),
        lock_(options.out, "tactile reproduce"),
        runner_({.folder = options.out,
                 .program = options.program,
                 .threads = threads_,
                 .new_progress = new_progress,
                 .tell = tell}) {
    std::sort(options_.histories.begin(), options_.histories.end());
    options_.histories.erase(std::unique(options_.histories.begin(), options_.histories.end()), options_.histories.end());
    if (options_.histories.empty()) throw Error("no history to train for; expected one at least");
    for (const microseconds history : options_.histories) check(HeatmapOptions{.history = history});
  }

  StudySummary run() {
    make_dataset();
    const Dataset dataset(dataset_file());
    dataset_ = &dataset;
    warn_of_runs_without_samples();
    divide_runs();
    plan_and_train();
    StudySummary summary;
    summary.study = write_results();
    summary.file = options_.out / "study.json";
    summary.done = runner_.done_now();
    summary.kept = runner_.records().size() - runner_.done_now();
    summary.errors = errors_;
    return summary;
  }

 private:
  // --- from nothing to a dataset

  fs::path dataset_file() const { return options_.data / "dataset.h5"; }

  void make_dataset() {
    simulate_runs();
    const RunsBelow below = is_there(options_.data) ? look_for_runs(options_.data) : RunsBelow{};
    if (warn_) std::for_each(below.misnamed.begin(), below.misnamed.end(), warn_);
    errors_ = below.unreadable;
    const std::vector<RunFolder>& runs = below.runs;
    if (runs.empty() && !errors_.empty()) throw Error(errors_.front());
    if (runs.empty())
      throw Error(options_.data.string() + ": no runs; expected DATA/<object>/<run>, or no such folder to simulate them");
    label(runs);
    cut_windows(runs);
    render();
  }

  /// Where there are no runs, or those that this study has begun to simulate.
  void simulate_runs() {
    std::vector<std::string> words{"simulate", options_.data.string(),       "--preset", options_.preset,
                                   "--seed",   std::to_string(options_.seed)};
    if (!options_.objects.empty()) words.insert(words.end(), {"--objects", fmt::format("{}", fmt::join(options_.objects, ","))});
    if (options_.runs) words.insert(words.end(), {"--runs", std::to_string(*options_.runs)});
    Step step{.name = "simulate",
              .command = command_of(words),
              .inputs = {{"data", from_study(options_.data)},
                         {"preset", options_.preset},
                         {"objects", options_.objects},
                         {"runs", options_.runs ? json(*options_.runs) : json()},
                         {"seed", options_.seed}},
              .outputs = [this] { return simulated_files(); },
              .work =
                  [this](const ProgressCallback& progress) {
                    simulate({.data = options_.data,
                              .preset = options_.preset,
                              .runs = options_.runs,
                              .objects = options_.objects,
                              .seed = options_.seed,
                              .force = options_.force,
                              .threads = threads_},
                             progress);
                  }};
    const json known = runner_.inputs_of("simulate");
    const bool is_ours = known.is_object() && known.contains("data") && known.at("data") == from_study(options_.data);
    simulated_here_ = is_ours || runs_below(options_.data).empty();
    if (simulated_here_) return runner_.run(step);
    // Runs of somebody else's are taken as they are: what would choose among simulated ones must not seem to choose among them.
    if (!options_.objects.empty() || options_.runs) {
      throw Error(
          fmt::format("{}: holds runs already, and all of them are studied; expected no --objects or --runs, which say what "
                      "to simulate, or another folder",
                      options_.data.string()));
    }
  }

  json simulated_files() const {
    json files;
    for (const RunFolder& run : runs_below(options_.data)) {
      files[run.name()] = {size_of(run.events()),      size_of(run.robot()), size_of(run.video()),
                           size_of(run.video_times()), size_of(run.truth()), hash_of_file(run.info())};
    }
    return files;
  }

  void label(const std::vector<RunFolder>& runs) {
    json inputs;
    for (const RunFolder& run : runs) {
      inputs[run.name()] = {state_of_file(run.events()), state_of_file(run.robot()), state_of_file(run.video()),
                            state_of_file(run.video_times()), state_of_file(run.info())};
    }
    std::map<std::string, std::string> why_not;
    runner_.run({.name = "label",
                 .command = command_of({"label", options_.data.string(), "--no-pictures"}),
                 .inputs = inputs,
                 .outputs = [&runs] { return labels_of(runs); },
                 .work =
                     [&](const ProgressCallback& progress) {
                       for (const RunOutcome& outcome : label_runs(runs, {.threads = threads_}, progress)) {
                         if (!outcome.error.empty()) why_not[outcome.run.name()] = outcome.error;
                       }
                       if (why_not.size() == runs.size()) throw Error(why_not.begin()->second);
                     }});
    for (const RunFolder& run : runs) {
      const auto why = why_not.find(run.name());
      if (why != why_not.end()) {
        errors_.push_back(why->second + "; " + run.name() + " is left out");
      } else if (!is_there(run.labels())) {
        errors_.push_back(fmt::format("{}: has no labels and is left out; 'tactile label {}' says why", run.folder.string(),
                                      shell_word(run.folder.string())));
      }
    }
  }

  /// The hash of each run's labels, null where it has none; null if no run has any.
  static json labels_of(const std::vector<RunFolder>& runs) {
    json hashes;
    bool any = false;
    for (const RunFolder& run : runs) {
      hashes[run.name()] = hash_of_file(run.labels());
      any = any || !hashes[run.name()].is_null();
    }
    return any ? hashes : json();
  }

  void cut_windows(const std::vector<RunFolder>& runs) {
    WindowsOptions windows;
    windows.sampling.seed = options_.seed;
    windows.sampling.history = std::max(shortest_stored, options_.histories.back());
    windows.include_flagged = options_.include_flagged;
    windows.strict = options_.strict;
    json events;
    for (const RunFolder& run : runs) events[run.name()] = state_of_file(run.events());
    std::vector<std::string> words{"windows", options_.data.string()};
    if (options_.seed != 1) words.insert(words.end(), {"--seed", std::to_string(options_.seed)});
    if (windows.sampling.history != shortest_stored)
      words.insert(words.end(), {"--history-ms", ms_text(windows.sampling.history)});
    json inputs = {{"sampling", windows.sampling}, {"labels", labels_of(runs)}, {"events", events}};
    if (options_.include_flagged) {
      words.emplace_back("--include-flagged");
      inputs["include_flagged"] = true;  // named only where it is on, so that steps done without it are kept
    }
    runner_.run({.name = "windows",
                 .command = command_of(words),
                 .inputs = inputs,
                 .outputs =
                     [this] {
                       try {
                         return json(Dataset(dataset_file()).manifest_hash());
                       } catch (const Error&) {
                         return json();
                       }
                     },
                 .work =
                     [&](const ProgressCallback& progress) {
                       warn_of_another_dataset(windows);
                       const DatasetSummary made = write_dataset(options_.data, dataset_file(), windows, threads_, progress);
                       for (const std::string& error : made.errors) {
                         if (std::find(errors_.begin(), errors_.end(), error) == errors_.end()) errors_.push_back(error);
                       }
                     }});
  }

  /// Another study's, or somebody's own, that will be replaced.
  void warn_of_another_dataset(const WindowsOptions& windows) const {
    if (!warn_) return;
    const std::vector<std::string> differing = settings_unlike_those_in(dataset_file(), windows);
    if (differing.empty()) return;
    warn_(fmt::format(
        "{} was made with other settings and is made anew with {}; give each study a data folder of its own to keep both",
        dataset_file().string(), fmt::join(differing, ", ")));
  }

  void render() {
    const Dataset dataset(dataset_file());
    for (const microseconds history : options_.histories) check_renders(dataset, {.history = history});
    runner_.run({.name = "heatmaps",
                 .command = command_of({"heatmaps", options_.data.string(), "--th", joined_ms(options_.histories)}),
                 .inputs = {{"manifest", dataset.manifest_hash()}, {"histories", joined_ms(options_.histories)}},
                 .outputs =
                     [&] {
                       const Dataset now(dataset_file());
                       json stored = json::array();
                       for (const microseconds history : options_.histories) {
                         const auto found = now.find_heatmaps(stored_name({.history = history}));
                         if (!found) return json();
                         stored.push_back(found->name);
                       }
                       return stored;
                     },
                 .work =
                     [&](const ProgressCallback& progress) {
                       std::vector<HeatmapOptions> histories;
                       for (const microseconds history : options_.histories) histories.push_back({.history = history});
                       store_heatmaps(Dataset(dataset_file()), histories, threads_, progress);
                     }});
  }

  // --- which runs, and which models

  void warn(const std::string& sentence) const {
    if (warn_) warn_(sentence);
  }

  /// In each call, for the step that leaves them out may be kept.
  void warn_of_runs_without_samples() {
    const std::vector<RunFolder> runs = runs_below(options_.data);
    const std::vector<RunWithoutSamples> without = runs_without_samples(*dataset_, runs);
    if (options_.strict) refuse_objects_left_out(objects_left_out(runs_of_objects_left_out(*dataset_), {}));
    if (!without.empty()) warn(sentence_on(without, runs.size(), options_.data, "tactile reproduce"));
  }

  /// What of the study's runs is not as asked for: a warning now, and in the results.
  void remark_on_runs() {
    const SplitOptions single{.kind = SplitKind::single_run, .train_run = options_.train_run};
    const SplitRemarks split = tactile::remarks_on(*dataset_, single, split_of(*dataset_, single));
    for (const auto& sentences : {split.substitutes, split.left_out, tactile::remarks_on(*dataset_, runs_)})
      remarks_.insert(remarks_.end(), sentences.begin(), sentences.end());
    for (const std::string& remark : remarks_) warn(remark);
  }

  void divide_runs() {
    runs_ = study_runs(*dataset_, options_.train_run, preset_.choice_runs);
    remark_on_runs();
    for (const auto& [name, runs] :
         {std::pair("choice", &runs_.choice), std::pair("reported", &runs_.reported), std::pair("all_test", &runs_.all_test)})
      sets_.push_back({name, *runs, names_of(*dataset_, *runs)});
    std::set<std::string> objects;
    for (const std::uint32_t run : runs_.train) objects.insert(dataset_->runs()[run].object);
    objects_.assign(objects.begin(), objects.end());
    std::set<std::string> left_out;
    for (const RunWithoutSamples& run : runs_of_objects_left_out(*dataset_)) left_out.insert(run.object);
    for (const std::string& object : options_.held_out.empty() ? default_held_out() : options_.held_out) {
      if (objects.contains(object)) {
        held_out_.push_back(object);
      } else if (!options_.held_out.empty() && !left_out.contains(object)) {
        throw Error(
            fmt::format("held-out object '{}': no training run of it; expected some of {}", object, fmt::join(objects_, ", ")));
      }
    }
    std::sort(held_out_.begin(), held_out_.end());
    if (held_out_.empty() && !options_.held_out.empty()) {
      throw Error(fmt::format("held-out objects {}: none of them has a run with samples; expected some of {}",
                              fmt::join(options_.held_out, ", "), fmt::join(objects_, ", ")));
    }
    if (held_out_.size() < objects_.size()) return;
    if (!options_.held_out.empty()) {
      throw Error(fmt::format("held-out objects {}: nothing is left to learn from; expected fewer than there are",
                              fmt::join(held_out_, ", ")));
    }
    held_out_.clear();
  }

  const RunSet& choice_set() const { return sets_[0]; }
  const RunSet& reported() const { return sets_[1]; }
  const RunSet& all_test() const { return sets_[2]; }

  std::uint64_t seed_at(unsigned place) const { return options_.seed + place; }

  StudyModel model_of(microseconds history, std::uint64_t seed, const std::vector<std::string>& held_out) const {
    StudyModel model;
    model.settings.rendering.history = history;
    model.settings.training.seed = seed;
    model.settings.training.epochs = epochs_;
    model.settings.training.engine = options_.engine;
    model.settings.split.train_run = options_.train_run;
    if (!held_out.empty()) model.settings.split = {SplitKind::unseen, options_.train_run, held_out};
    model.bundle = {options_.models / default_name(model.settings)};
    for (const std::uint32_t run : runs_.all_test) {
      const std::string& object = dataset_->runs()[run].object;
      if (held_out.empty() || std::find(held_out.begin(), held_out.end(), object) != held_out.end()) model.runs.push_back(run);
    }
    return model;
  }

  StudyModel seen_model(microseconds history, std::uint64_t seed) const { return model_of(history, seed, {}); }

  Step training_of(const StudyModel& model) const {
    return training_step(*dataset_, model.settings, model.bundle, {options_.data, options_.models, from_study(options_.models)});
  }

  /// Named where it is not the usual one, whose results stay as they are.
  json with_engine(json inputs) const {
    if (options_.engine != EngineKind::fast) inputs["engine"] = name_of(options_.engine);
    return inputs;
  }

  fs::path samples_file(const StudyModel& model) const { return options_.out / "samples" / (model.name() + ".json"); }

  Step judging_of(const StudyModel& model) const {
    const fs::path file = samples_file(model);
    return {.name = "judge-" + model.name(),
            .command = "",
            .inputs = with_engine({{"manifest", dataset_->manifest_hash()},
                                   {"weights", read_description(model.bundle).weights_sha256},
                                   {"runs", names_of(*dataset_, model.runs)}}),
            .outputs = [file] { return hash_of_file(file); },
            .work =
                [this, model, file](const ProgressCallback& progress) {
                  const Classifier classifier = open_classifier(model.bundle.folder, threads_, options_.engine);
                  const auto confusions = sample_confusions(*dataset_, classifier, model.runs, {.threads = threads_}, progress);
                  std::vector<RunVerdicts> verdicts;
                  for (std::size_t i = 0; i < model.runs.size(); ++i)
                    verdicts.push_back({name_of(dataset_->runs()[model.runs[i]]), confusions[i].object, confusions[i].confusion});
                  write_verdicts(file, verdicts);
                }};
  }

  /// What models, counted together, said of the samples of these runs.
  std::vector<RunConfusion> judged(const std::vector<StudyModel>& models, const std::vector<std::string>& runs) const {
    std::vector<std::vector<RunConfusion>> each;
    for (const StudyModel& model : models) each.push_back(verdicts_on(read_verdicts(samples_file(model)), runs));
    return together(each);
  }

  // --- training, choice, evaluation

  void train_and_judge(const std::vector<StudyModel>& models) {
    std::vector<Step> steps;
    for (const StudyModel& model : models) steps.push_back(training_of(model));
    runner_.run_side_by_side(steps);
    for (const StudyModel& model : models) runner_.run(judging_of(model));
  }

  std::vector<StudyModel> unseen_models() const {
    std::vector<StudyModel> models;
    if (held_out_.empty()) return models;
    for (unsigned place = 0; place < options_.seeds; ++place) models.push_back(model_of(history_, seed_at(place), held_out_));
    return models;
  }

  void plan_and_train() {
    std::vector<StudyModel> due;
    for (const microseconds history : options_.histories) {
      for (unsigned place = 0; place < options_.seeds; ++place) {
        models_[history].push_back(seen_model(history, seed_at(place)));
        due.push_back(models_[history].back());
      }
    }
    if (options_.splits > 0) {
      if (held_out_.empty())
        throw Error("--splits: no objects to hold out of training; expected some of --held-out in the dataset");
      splits_ = drawn_splits(all_splits(objects_, held_out_.size()), options_.splits, options_.seed);
    }
    const bool chosen_on_runs = !runs_.choice.empty();
    const auto add_held_out = [&](std::vector<StudyModel>& models) {
      unseen_ = unseen_models();
      models.insert(models.end(), unseen_.begin(), unseen_.end());
      for (const HeldOutSplit& split : splits_) {
        split_models_.push_back(model_of(history_, seed_at(0), split.held_out));
        const auto has_its_name = [&](const StudyModel& model) { return model.name() == split_models_.back().name(); };
        if (std::none_of(models.begin(), models.end(), has_its_name)) models.push_back(split_models_.back());
      }
    };
    if (!chosen_on_runs) {
      history_ = nearest_to_default();
      add_held_out(due);  // nothing to wait for: all of it side by side
    }
    train_and_judge(due);
    for (const RunSet& set : sets_) {
      if (set.runs.empty()) continue;
      for (const auto& [history, models] : models_) {
        confusions_[set.name][history] = judged(models, set.names);
        accuracies_[set.name][history] = accuracy_of(confusions_[set.name][history]);
      }
      choices_[set.name] = choose_history(accuracies_[set.name]);
    }
    paper_history_ = choices_.at("all_test").history;
    if (chosen_on_runs) {
      history_ = choices_.at("choice").history;
      std::vector<StudyModel> held_out;
      add_held_out(held_out);
      train_and_judge(held_out);
    }
    for (unsigned place = 0; place < options_.seeds; ++place)
      evaluate_on(place == 0 ? "reported" : fmt::format("reported-s{}", seed_at(place)), models_.at(history_)[place], reported());
    evaluate_on("all_test", models_.at(paper_history_).front(), all_test());
    predict_full_run();
  }

  microseconds nearest_to_default() const {
    return *std::min_element(options_.histories.begin(), options_.histories.end(), [](microseconds a, microseconds b) {
      return std::chrono::abs(a - default_history) < std::chrono::abs(b - default_history);
    });
  }

  struct Evaluated {
    std::string id;
    StudyModel model;
    std::string runs;
    fs::path json_file, csv_file;
  };

  void evaluate_on(const std::string& id, const StudyModel& model, const RunSet& set) {
    for (const Evaluated& other : evaluated_) {
      // The same model on the same runs needs no second look.
      const bool same_runs = other.runs == set.name || (runs_.reported == runs_.all_test);
      if (other.model.name() == model.name() && same_runs) {
        evaluated_.push_back({id, model, set.name, other.json_file, other.csv_file});
        return;
      }
    }
    const fs::path stem = options_.out / "evaluations" / (set.name + "-" + model.name());
    const fs::path json_file = stem.string() + ".json", csv_file = stem.string() + ".csv";
    runner_.run({.name = "evaluate-" + set.name + "-" + model.name(),
                 .command = "",
                 .inputs = with_engine({{"manifest", dataset_->manifest_hash()},
                                        {"weights", read_description(model.bundle).weights_sha256},
                                        {"truth", truths_of(set.runs)},
                                        {"form", evaluation_form},
                                        {"runs", set.names}}),
                 .outputs =
                     [json_file, csv_file] {
                       return hashes_of({json_file, csv_file});
                     },
                 .work =
                     [&](const ProgressCallback& progress) {
                       const Classifier classifier = open_classifier(model.bundle.folder, threads_, options_.engine);
                       const Evaluation evaluation = evaluate(*dataset_, classifier, set.runs, {.threads = threads_}, progress);
                       write_whole(csv_file, table_of(evaluation));
                       write_json(json_file, evaluation);
                     }});
    evaluated_.push_back({id, model, set.name, json_file, csv_file});
  }

  /// What evaluations read beside the dataset.
  json truths_of(const std::vector<std::uint32_t>& runs) const {
    json states = json::array();
    for (const std::uint32_t run : runs) states.push_back(hash_of_file(dataset_->run_folder(run) / "truth.json"));
    return states;
  }

  fs::path outcome_of_full_run() const { return fs::path(full_run_file_).replace_extension(".json"); }

  /// One run over time, as the paper's figure 8: of the water bottle where there is one.
  void predict_full_run() {
    std::uint32_t shown = runs_.reported.front();
    for (auto run = runs_.reported.rbegin(); run != runs_.reported.rend(); ++run) {
      if (dataset_->runs()[*run].object == "water-bottle") shown = *run;
    }
    const StudyModel& model = models_.at(history_).front();
    const DatasetRun& run = dataset_->runs()[shown];
    full_run_ = name_of(run);
    full_run_file_ = options_.out / "runs" / (run.object + "-" + run.run + ".csv");
    runner_.run(
        {.name = "run-" + run.object + "-" + run.run,
         .command = command_of({"eval", options_.data.string(), "--run", full_run_, "--models", options_.models.string(),
                                "--model", model.name(), "--out", (options_.out / "runs").string(), "--engine",
                                std::string(name_of(options_.engine))}),
         .inputs = with_engine({{"manifest", dataset_->manifest_hash()},
                                {"weights", read_description(model.bundle).weights_sha256},
                                {"form", evaluation_form},
                                {"truth", truths_of({shown})}}),
         .outputs =
             [this] {
               return hashes_of({full_run_file_, outcome_of_full_run()});
             },
         .work =
             [&](const ProgressCallback& progress) {
               check_unchanged(*dataset_, shown);
               const Classifier classifier = open_classifier(model.bundle.folder, threads_, options_.engine);
               const RunFolder folder{dataset_->run_folder(shown), run.object, run.run};
               std::map<CameraTime, Touch> samples;
               for (const Sample& sample : dataset_->samples()) {
                 if (sample.run_index == shown) samples[sample.t] = sample.touch;
               }
               const std::size_t total = expected_ticks(folder.events(), classifier.rendering());
               std::size_t done = 0;
               const auto prediction = predict_run(
                   folder, classifier,
                   {.guard = dataset_->sampling().guard, .include_flagged = options_.include_flagged, .threads = threads_},
                   [&](std::size_t ticks) {
                     done += ticks;
                     tactile::tell(progress, done, total, "every tick of " + full_run_);
                   });
               write_prediction(full_run_file_, prediction, samples);
               write_json(outcome_of_full_run(), outcome_json(prediction));
             }});
  }

  // --- results

  /// A path as study.json has it: from the study's folder on.
  std::string from_study(const fs::path& path) const { return from_folder(path, options_.out); }

  UnseenComparison compared(const std::vector<StudyModel>& held_out, const RunSet& set) const {
    std::vector<std::string> runs;
    for (const std::uint32_t run : set.runs) {
      const auto& judged_on = held_out.front().runs;
      if (std::find(judged_on.begin(), judged_on.end(), run) != judged_on.end()) runs.push_back(name_of(dataset_->runs()[run]));
    }
    if (runs.empty()) return {};
    // As many models with the objects as without them, of the same seeds.
    const auto& all = models_.at(history_);
    const std::vector<StudyModel> with(all.begin(),
                                       all.begin() + static_cast<std::ptrdiff_t>(std::min(all.size(), held_out.size())));
    UnseenComparison comparison = unseen_comparison(judged(with, runs), judged(held_out, runs));
    comparison.runs = std::move(runs);
    return comparison;
  }

  const Evaluated& evaluation_on(const std::string& id) const {
    return *std::find_if(evaluated_.begin(), evaluated_.end(), [&](const Evaluated& one) { return one.id == id; });
  }

  std::vector<Claim> claims_on(const RunSet& set) const {
    const Evaluated& evaluated = evaluation_on(set.name);
    const std::string where = evaluated.json_file.string();
    const json evaluation = read_json(evaluated.json_file);
    ClaimInputs inputs;
    inputs.histories = confusions_.at(set.name);
    for (const microseconds history : StudyOptions{}.histories) {
      if (!inputs.histories.contains(history)) inputs.untrained.push_back(history);
    }
    inputs.detections = detections_in(evaluation, where);
    inputs.tick_ms = member<double>(evaluation, "tick_ms", where);
    inputs.history_ms = in_ms(evaluated.model.settings.rendering.history);
    const JsonView over_time = JsonView(evaluation, where, MissingMember::is_error)["over_time"];
    inputs.over_time = over_time["both"].get<ShareOverTime>();
    inputs.after_ms = over_time["after_ms"].number();
    if (!unseen_.empty()) {
      const UnseenComparison comparison = compared(unseen_, set);
      if (!comparison.runs.empty()) {
        const auto& all = models_.at(history_);
        inputs.seen = judged(all, comparison.runs);
        inputs.held_out = judged(unseen_, comparison.runs);
      }
    }
    return claims_of(inputs);
  }

  json training_json(const StudyModel& model) const {
    return {{"seed", model.settings.training.seed},
            {"name", model.name()},
            {"folder", from_study(model.bundle.folder)},
            {"history", from_study(model.bundle.history())},
            {"weights_sha256", read_description(model.bundle).weights_sha256},
            {"samples", from_study(samples_file(model))}};
  }

  json histories_json() const {
    json histories = json::array();
    for (const auto& [history, models] : models_) {
      json entry = {{"th_ms", in_ms(history)}, {"models", json::array()}, {"accuracy", {{"choice", nullptr}}}};
      for (const StudyModel& model : models) {
        json one = training_json(model);
        one["accuracy"] = accuracy_of(judged({model}, reported().names)).mean;
        entry["models"].push_back(one);
      }
      for (const auto& [set, accuracies] : accuracies_) entry["accuracy"][set] = accuracies.at(history);
      histories.push_back(entry);
    }
    return histories;
  }

  /// Where another history has the higher mean, the rule that decides all the same.
  static std::string rule_of(const HistoryChoice& made, const AccuracyByHistory& accuracies) {
    const auto best = std::max_element(accuracies.begin(), accuracies.end(),
                                       [](const auto& a, const auto& b) { return a.second.mean.value < b.second.mean.value; });
    const double chosen = accuracies.at(made.history).mean.value;
    if (!(best->second.mean.value > chosen)) return " The mean over objects is the highest there, too.";
    return fmt::format(
        " The mean over objects is higher at {} ms there, {:.2f} % against {:.2f} %; the rule is the paper's: the history that "
        "is "
        "best for the most objects, the mean among equals alone.",
        ms_text(best->first), 100 * best->second.mean.value, 100 * chosen);
  }

  /// What intervals hold, and what they do not.
  std::string words_on_seeds() const {
    if (options_.seeds == 1)
      return "One training each: intervals are over runs and objects, and do not hold what another seed would change.";
    return fmt::format(
        "{} trainings each, whose verdicts are counted together, and of delays the first: intervals are over runs and objects, "
        "and do not hold what other seeds would change. The accuracy of each training stands in the table of models.",
        options_.seeds);
  }

  json choice_json() const {
    const bool chosen_on_runs = !runs_.choice.empty();
    json choice = {{"th_ms", in_ms(history_)},
                   {"model", models_.at(history_).front().name()},
                   {"chosen_on", chosen_on_runs ? "choice" : "default"},
                   {"best", {{"choice", nullptr}}}};
    if (chosen_on_runs) {
      const HistoryChoice& made = choices_.at("choice");
      choice["why"] = fmt::format("{} ms is the best history for {} of {} objects on the runs to choose on ({}).{}",
                                  ms_text(history_), made.counts.at(history_), made.of_objects.size(),
                                  fmt::join(preset_.choice_runs, ", "), rule_of(choices_.at("choice"), accuracies_.at("choice")));
    } else {
      choice["why"] = fmt::format("There is no run to choose a history on beside those reported on, so that t_h stays {} ms.",
                                  ms_text(history_));
    }
    for (const auto& [set, made] : choices_) choice["best"][set] = made;
    return choice;
  }

  json paper_way_json() const {
    const HistoryChoice& made = choices_.at("all_test");
    return {{"th_ms", in_ms(paper_history_)},
            {"model", models_.at(paper_history_).front().name()},
            {"why",
             fmt::format("{} ms is the best history for {} of {} objects on all test runs, the very runs that are reported on.{}",
                         ms_text(paper_history_), made.counts.at(paper_history_), made.of_objects.size(),
                         rule_of(made, accuracies_.at("all_test")))}};
  }

  json evaluations_json() const {
    json evaluations = json::array();
    for (const Evaluated& one : evaluated_) {
      const json full = read_json(one.json_file);
      const JsonView view(full, one.json_file.string(), MissingMember::is_error);
      const double tick_ms = view["tick_ms"].number();
      const auto slip = view["delay_ms"]["slip"].get<DelayTable>();
      json entry = {{"id", one.id},
                    {"th_ms", in_ms(one.model.settings.rendering.history)},
                    {"seed", one.model.settings.training.seed},
                    {"model", one.model.name()},
                    {"runs", one.runs},
                    {"json", from_study(one.json_file)},
                    {"csv", from_study(one.csv_file)}};
      for (const char* key : {"accuracy", "confusion", "accuracy_by_guard", "delay_ms", "false_alarms_per_min", "over_time"})
        entry[key] = full.at(key);
      entry["slip_at_once"]["objects"] = told_at_once(slip.objects, tick_ms);
      evaluations.push_back(entry);
    }
    return evaluations;
  }

  json settings_json() const {
    std::vector<std::uint64_t> seeds;
    for (unsigned place = 0; place < options_.seeds; ++place) seeds.push_back(seed_at(place));
    json histories = json::array();
    for (const microseconds history : options_.histories) histories.push_back(in_ms(history));
    return {{"data", from_study(options_.data)},
            {"models", from_study(options_.models)},
            {"preset", options_.preset},
            {"seed", options_.seed},
            {"seeds", seeds},
            {"train_run", options_.train_run},
            {"held_out", held_out_},
            {"histories_ms", histories},
            {"epochs", epochs_},
            {"engine", name_of(options_.engine)},
            {"include_flagged", options_.include_flagged},
            {"splits", splits_.size()},
            {"objects", simulated_here_ && !options_.objects.empty() ? json(options_.objects) : json()},
            {"runs", simulated_here_ && options_.runs ? json(*options_.runs) : json()}};
  }

  json write_results() const {
    const BootstrapOptions bootstrap;
    json study = {{"format", "tactile-study-1"},
                  {"title", fmt::format("The paper's study on {} runs ({})", dataset_->simulated() ? "simulated" : "real",
                                        options_.preset)},
                  {"simulated", dataset_->simulated()},
                  {"settings", settings_json()},
                  {"software", software_json()},
                  {"machine", machine_json(threads_)},
                  {"bootstrap",
                   {{"draws", bootstrap.draws},
                    {"confidence", bootstrap.confidence},
                    {"seed", bootstrap.seed},
                    {"trainings", words_on_seeds()}}},
                  {"steps", steps_json(runner_.records())},
                  {"dataset",
                   {{"file", from_study(dataset_file())},
                    {"manifest_hash", dataset_->manifest_hash()},
                    {"samples", dataset_->samples().size()},
                    {"tick_ms", in_ms(dataset_->sampling().tick)},
                    {"guard_ms", in_ms(dataset_->sampling().guard)}}},
                  {"runs", {{"train", names_of(*dataset_, runs_.train)}}},
                  {"histories", histories_json()},
                  {"choice", choice_json()},
                  {"paper_way", paper_way_json()},
                  {"evaluations", evaluations_json()},
                  {"full_runs", json::array({json{{"run", full_run_},
                                                  {"model", models_.at(history_).front().name()},
                                                  {"th_ms", in_ms(history_)},
                                                  {"csv", from_study(full_run_file_)}}})},
                  {"unseen", nullptr},
                  {"splits", json::array()},
                  {"splits_mean", nullptr}};
    for (const RunSet& set : sets_) study["runs"][set.name] = set.names;
    study["remarks"] = remarks_;
    study["left_out"] = left_out_of(*dataset_, runs_below(options_.data));

    std::vector<UnseenRow> unseen_rows;
    const auto add_comparison = [&](json& entry, const std::string& split, const std::vector<StudyModel>& held_out) {
      for (const RunSet* set : {&reported(), &all_test()}) {
        const UnseenComparison comparison = compared(held_out, *set);
        entry[set->name] = comparison.runs.empty() ? json() : json(comparison);
        if (!comparison.runs.empty()) unseen_rows.push_back({split, set->name, comparison});
      }
    };
    if (!unseen_.empty()) {
      json& unseen =
          study["unseen"] = {{"th_ms", in_ms(history_)},
                             {"held_out", held_out_},
                             {"models", {{"seen", models_.at(history_).front().name()}, {"held_out", unseen_.front().name()}}}};
      for (const StudyModel& model : unseen_) unseen["trainings"].push_back(training_json(model));
      add_comparison(unseen, "paper", unseen_);
    }
    for (std::size_t i = 0; i < splits_.size(); ++i) {
      json split = {{"name", splits_[i].name}, {"held_out", splits_[i].held_out}, {"model", split_models_[i].name()}};
      split["training"] = training_json(split_models_[i]);
      add_comparison(split, splits_[i].name, {split_models_[i]});
      study["splits"].push_back(split);
    }
    if (!splits_.empty()) study["splits_mean"] = {{"reported", splits_mean(reported())}, {"all_test", splits_mean(all_test())}};

    std::vector<Claim> claims = claims_on(reported());
    const std::vector<Claim> on_all = claims_on(all_test());
    for (std::size_t i = 0; i < claims.size(); ++i) claims[i].all_test = static_cast<const ClaimOutcome&>(on_all[i]);
    study["claims"] = claims;
    study["summary"] = summary_of(claims, dataset_->simulated());

    std::vector<AccuracyRow> rows;
    for (const RunSet& set : sets_) {
      if (set.runs.empty()) continue;
      for (const auto& [history, accuracy] : accuracies_.at(set.name)) rows.push_back({in_ms(history), set.name, &accuracy});
    }
    write_if_changed(options_.out / "accuracy.csv", accuracy_csv(rows));
    write_if_changed(options_.out / "unseen.csv", unseen_csv(unseen_rows));
    write_if_changed(options_.out / "claims.csv", claims_csv(claims));
    write_if_changed(options_.out / "study.json", json_text(study, 2) + "\n");
    return study;
  }

  /// Over all drawn splits: each object's runs count once for every split that holds it out.
  json splits_mean(const RunSet& set) const {
    std::map<std::string, RunConfusion> with, without;
    for (const StudyModel& model : split_models_) {
      const UnseenComparison comparison = compared({model}, set);
      if (comparison.runs.empty()) continue;
      const auto seen = judged({models_.at(history_).front()}, comparison.runs), held_out = judged({model}, comparison.runs);
      for (std::size_t i = 0; i < comparison.runs.size(); ++i) {
        with[comparison.runs[i]].object = without[comparison.runs[i]].object = seen[i].object;
        with[comparison.runs[i]].confusion += seen[i].confusion;
        without[comparison.runs[i]].confusion += held_out[i].confusion;
      }
    }
    if (with.empty()) return {};
    std::vector<RunConfusion> seen, held_out;
    for (const auto& [run, confusion] : with) {
      seen.push_back(confusion);
      held_out.push_back(without.at(run));
    }
    return accuracy_difference(seen, held_out).mean;
  }

  static void write_if_changed(const fs::path& file, const std::string& text) {
    if (!fs::exists(file) || read_text(file) != text) write_whole(file, text);
  }

  StudyOptions options_;
  std::function<void(const std::string&)> warn_;
  std::vector<std::string> errors_;
  PresetSettings preset_;
  unsigned epochs_, threads_;
  FolderLock lock_;
  StepRunner runner_;
  const Dataset* dataset_ = nullptr;
  bool simulated_here_ = false;

  StudyRuns runs_;
  std::vector<std::string> remarks_;  ///< in what they are not as asked for
  std::vector<RunSet> sets_;
  std::vector<std::string> objects_, held_out_;
  std::map<microseconds, std::vector<StudyModel>> models_;  ///< one for each seed
  std::vector<StudyModel> unseen_, split_models_;
  std::vector<HeldOutSplit> splits_;
  std::map<std::string, std::map<microseconds, std::vector<RunConfusion>>> confusions_;  ///< by the name of the set of runs
  std::map<std::string, AccuracyByHistory> accuracies_;
  std::map<std::string, HistoryChoice> choices_;
  microseconds history_{0}, paper_history_{0};
  std::vector<Evaluated> evaluated_;
  std::string full_run_;
  fs::path full_run_file_;
};

}  // namespace

StudySummary run_study(const StudyOptions& options, const NewProgress& new_progress,
                       const std::function<void(const std::string& step, bool kept)>& tell,
                       const std::function<void(const std::string& sentence)>& warn) {
  if (options.seeds == 0) throw Error("no seed to train with; expected one at least");
  return Study(options, new_progress, tell, warn).run();
}

}  // namespace tactile
