#pragma once

#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "tactile/report/classifier_plots.hpp"
#include "tactile/report/object_plots.hpp"
#include "tactile/results/evaluation.hpp"
#include "tactile/results/stress.hpp"
#include "tactile/results/study.hpp"
#include "tactile/results/trade.hpp"

namespace tactile::report {

/// An evaluation as a section of the report.
struct ReportedEvaluation {
  std::string model;                                             ///< name
  std::string runs;                                              ///< on which runs, in words; may be empty
  double history_ms = std::numeric_limits<double>::quiet_NaN();  ///< NaN of a stream
  results::Evaluation scores;
};

/// Objects seen in training and the same objects held out, on one set of runs.
struct UnseenSection {
  std::string name, setting;  ///< "LeNet, t_h 40 ms", "th040"; empty where the comparison names its models
  std::string runs;           ///< in words; may be empty
  results::UnseenComparison comparison;
};

struct ReportedTable {
  std::string caption;
  std::vector<std::string> head;
  std::vector<std::vector<std::string>> rows;
};

/// Accuracies by history on one set of runs; the mean over objects first.
struct ReportedHistories {
  std::string runs;
  std::vector<HistoryCurve> curves;
};

/// The contents of a report, from wherever they were read.
struct ReportInput {
  std::string title;
  bool simulated = false;
  std::vector<std::string> found;  ///< sentences
  std::vector<std::string> remarks;
  std::vector<results::Claim> claims;
  std::vector<ReportedTable> left_out;  ///< runs and intervals that are in no sample, and why
  std::vector<ReportedHistories> histories;
  std::vector<results::StudiedSetting> settings_on_whole_runs;  ///< of a study, the most important first
  std::vector<ReportedEvaluation> evaluations;
  std::vector<results::ReportedRun> runs;
  std::vector<UnseenSection> unseen;
  std::vector<TrainingCurve> trainings;
  std::optional<results::Trade> trade;    ///< of speed for accuracy
  std::optional<results::Stress> stress;  ///< of worsened runs
  std::vector<ReportedTable> settings;
  std::filesystem::path data;        ///< folder of runs; empty if not known
  double history_ms = 40;            ///< of the frames shown
  std::vector<std::string> missing;  ///< sentences: what is not there, and how to get it
};

/// Reads a folder of `tactile reproduce`. Files that `study.json` names and that do not exist are listed as missing.
/// @throws Error  if study.json, or a file that it names and that exists, is not of its format
ReportInput read_study(const std::filesystem::path& folder);

/// The folder of a model, and the file of its results; there may be none.
struct ModelToReport {
  ModelToReport(std::filesystem::path of) : folder(std::move(of)), evaluation(folder / "eval.json") {}
  ModelToReport(std::filesystem::path of, std::filesystem::path judged) : folder(std::move(of)), evaluation(std::move(judged)) {}

  std::filesystem::path folder, evaluation;
};

/// Reads models with their evaluations. The first model gives all its results, the others their accuracies by history and their
/// trainings.
/// @param models  not empty
/// @param data    folder of runs for the frames; empty: none
/// @throws Error  if a model.json is missing, or a file is not of its format
ReportInput read_models(const std::vector<ModelToReport>& models, const std::filesystem::path& data);

}  // namespace tactile::report
