#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tactile/core/time.hpp"
#include "tactile/results/accuracy.hpp"
#include "tactile/results/claim.hpp"
#include "tactile/results/step_record.hpp"
#include "tactile/results/training_spread.hpp"
#include "tactile/results/unseen_comparison.hpp"
#include "tactile/results/variance_shares.hpp"

namespace tactile::results {

/// A result on each set of runs of a study; nothing on a set without runs.
template <class T>
struct OnRunSets {
  std::optional<T> choice{};    ///< to choose a history on
  std::optional<T> reported{};  ///< neither trained nor chosen on
  std::optional<T> all_test{};  ///< all but those trained on, as in the paper

  /// By the name of the set in JSON.
  std::optional<T>& operator[](std::string_view set) {
    return set == "choice" ? choice : set == "reported" ? reported : all_test;
  }
  const std::optional<T>& operator[](std::string_view set) const {
    return set == "choice" ? choice : set == "reported" ? reported : all_test;
  }
};

/// How intervals were drawn.
struct StudyBootstrap : BootstrapOptions {
  std::string trainings{};  ///< a sentence: whether intervals are over trainings
};

struct StudyDataset {
  std::string file{}, manifest_hash{};
  std::uint64_t samples = 0;
  double tick_ms = std::numeric_limits<double>::quiet_NaN(), guard_ms = tick_ms;
};

/// What one training of every setting learned from, and what it is judged on.
struct StudyTraining {
  std::uint64_t seed = 0;
  std::string train_run{};                                             ///< id of each object's training run
  double history_ms = std::numeric_limits<double>::quiet_NaN();        ///< that it chose
  std::vector<std::string> train{}, choice{}, reported{}, all_test{};  ///< runs: "fan/03"
};

/// A model that the study trained.
struct TrainedModel {
  std::size_t training = 0;  ///< which of `Study::trainings`
  std::uint64_t seed = 0;
  double history_ms = std::numeric_limits<double>::quiet_NaN();
  std::string name{};
  std::string folder{}, history{}, samples{};  ///< paths: of the model, its history.csv, and its judged samples
  std::string weights_sha256{};
  std::optional<Figure> accuracy{};  ///< mean over objects on its reported runs; only in `StudyHistory`
};

/// One history t_h.
struct StudyHistory {
  double history_ms = std::numeric_limits<double>::quiet_NaN();
  std::vector<TrainedModel> models{};  ///< one for each training
  OnRunSets<Accuracy> accuracy{};      ///< over all trainings
};

/// The best history for each object, and the one chosen by them.
struct HistoryChoice {
  microseconds history{0};                           ///< the best one for the most objects
  std::map<std::string, microseconds> of_objects{};  ///< the best one for each object, the shortest of equals
  std::map<microseconds, std::size_t> counts{};      ///< the number of objects that each history is best for, 0 included
};

/// {"th_ms", "objects": {"fan": 40}, "counts": {"2": 0, "40": 6}}
void to_json(nlohmann::json& json, const HistoryChoice& choice);
void from_json(const JsonView& json, HistoryChoice& choice);

struct ChosenHistory {
  double history_ms = std::numeric_limits<double>::quiet_NaN();
  std::string model{};  ///< its model of the first training
  std::string why{};    ///< a sentence
};

/// The history to use.
struct StudyChoice : ChosenHistory {
  std::string chosen_on{};          ///< "choice", or "default" if no run is left to choose on
  std::vector<double> trainings{};  ///< the history that each training chose [ms]
  OnRunSets<HistoryChoice> best{};
};

/// What a `StudyEvaluation` has of eval.json, by its keys there.
inline constexpr std::array evaluation_figures{"accuracy", "confusion", "accuracy_by_guard", "delay_ms", "false_alarms_per_min",
                                               "over_time"};

/// The trainings of a setting, evaluated on every tick of their runs.
struct StudyEvaluation {
  std::string id{};                     ///< "reported", "all_test"
  std::vector<TrainedModel> models{};   ///< one for each training; of older files one with its name and history only
  std::string runs{};                   ///< "reported", "all_test"
  std::string json_file{}, csv_file{};  ///< paths, as `tactile eval` writes them
  nlohmann::json figures = nlohmann::json::object();  ///< `evaluation_figures`
  std::map<std::string, bool> slip_at_once{};         ///< whether each slip of an object was detected at its first tick
};

/// A run over time, as a CSV of `tactile eval --run`.
struct ReportedRun {
  std::string run{}, model{};
  double history_ms = std::numeric_limits<double>::quiet_NaN();
  std::filesystem::path csv{};  ///< how its intervals were detected lies next to it, as .json
};

/// Objects held out of training. `on` has no runs to choose on.
struct StudyUnseen {
  std::vector<std::vector<std::string>> held_out{};  ///< objects that were held out together
  UnseenComparison::Models models{};                 ///< of the first training
  std::vector<TrainedModel> trainings{};             ///< without the objects
  OnRunSets<UnseenComparison> on{};
};

/// One division of the objects, drawn at random. `on` has no runs to choose on.
struct StudySplit {
  std::string name{};                      ///< "split-017"
  std::vector<std::string> held_out{};     ///< objects
  std::string model{};                     ///< name
  std::optional<TrainedModel> training{};  ///< nothing in older files
  OnRunSets<UnseenComparison> on{};
};

/// A run, or one interval of it, that a study uses neither to train nor to judge.
struct LeftOut {
  std::string run{};     ///< "fan/03"
  std::string what{};    ///< "run", or an interval's id: "press-1"
  std::string reason{};  ///< in words
};

/// The paper's study. Paths are relative to its folder.
struct Study {
  std::string title{};
  bool simulated = false;
  nlohmann::json settings = nlohmann::json::object(), software = nullptr, machine = nullptr;
  StudyBootstrap bootstrap{};
  std::vector<StepRecord> steps{};
  StudyDataset dataset{};
  std::vector<StudyTraining> trainings{};
  std::vector<StudyHistory> histories{};  ///< ascending
  StudyChoice choice{};
  ChosenHistory paper_way{};                 ///< chosen on the runs that are also reported on
  std::optional<VarianceShares> variance{};  ///< of the reported accuracy; nothing where it cannot be divided
  TrainingSpread training_spread{};          ///< of the chosen history
  std::vector<StudyEvaluation> evaluations{};
  std::vector<ReportedRun> full_runs{};
  std::optional<StudyUnseen> unseen{};  ///< nothing where no object was held out
  std::vector<StudySplit> splits{};
  OnRunSets<Figure> splits_mean{};  ///< of the differences over all splits; nothing on runs to choose on
  std::vector<std::string> remarks{};
  std::vector<LeftOut> left_out{};
  std::vector<Claim> claims{};
  std::vector<std::string> found{};  ///< sentences
  std::string summary{};             ///< of the claims, a sentence
};

/// As study.json has it; docs/format/ lists its keys.
void to_json(nlohmann::json& json, const Study& study);
void from_json(const JsonView& json, Study& study);  ///< @throws Error  if it is of another format

void to_json(nlohmann::json& json, const StudyBootstrap& bootstrap);
void from_json(const JsonView& json, StudyBootstrap& bootstrap);
void to_json(nlohmann::json& json, const StudyDataset& dataset);
void from_json(const JsonView& json, StudyDataset& dataset);
void to_json(nlohmann::json& json, const StudyTraining& training);
void from_json(const JsonView& json, StudyTraining& training);
void to_json(nlohmann::json& json, const TrainedModel& model);
void from_json(const JsonView& json, TrainedModel& model);
void to_json(nlohmann::json& json, const StudyHistory& history);
void from_json(const JsonView& json, StudyHistory& history);
void to_json(nlohmann::json& json, const ChosenHistory& chosen);
void from_json(const JsonView& json, ChosenHistory& chosen);
void to_json(nlohmann::json& json, const StudyChoice& choice);
void from_json(const JsonView& json, StudyChoice& choice);
void to_json(nlohmann::json& json, const StudyEvaluation& evaluation);
void from_json(const JsonView& json, StudyEvaluation& evaluation);
void to_json(nlohmann::json& json, const ReportedRun& run);
void from_json(const JsonView& json, ReportedRun& run);
void to_json(nlohmann::json& json, const StudyUnseen& unseen);
void from_json(const JsonView& json, StudyUnseen& unseen);
void to_json(nlohmann::json& json, const StudySplit& split);
void from_json(const JsonView& json, StudySplit& split);
void to_json(nlohmann::json& json, const LeftOut& left_out);
void from_json(const JsonView& json, LeftOut& left_out);

}  // namespace tactile::results
