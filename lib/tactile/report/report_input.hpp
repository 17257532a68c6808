#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tactile/report/reported_trade.hpp"
#include "tactile/report/result_plots.hpp"
#include "tactile/results/claim.hpp"

namespace tactile {

struct ReportedFalseAlarms {
  std::string of;  ///< "network", "always_press"
  Figure per_min;
  DelaySummary press, slip;  ///< over all objects
  std::optional<std::uint64_t> count, after_intervals,
      unlabelled;                                              ///< begun in none time, within the guard, in motion nobody labels
  double none_min = std::numeric_limits<double>::quiet_NaN();  ///< what `per_min` is per [min]
};

/// Accuracy on one object, or the mean over all, in several ways.
struct ReportedAccuracy {
  std::string object;
  std::vector<Figure> values;  ///< one for each of `ReportedEvaluation::accuracy_of`
};

/// An `eval.json`.
struct ReportedEvaluation {
  std::string id;     ///< "reported", "all_test"; names its figures
  std::string model;  ///< name
  std::string runs;   ///< on which runs, in words; may be empty
  double history_ms = std::numeric_limits<double>::quiet_NaN(), tick_ms = history_ms, guard_ms = history_ms;
  std::string confirm;
  std::vector<std::string> accuracy_of;      ///< "network", "guard 0 ms", "baseline event_count", "by the truth"
  std::vector<ReportedAccuracy> accuracies;  ///< the mean over objects first
  std::optional<Confusion> confusion;
  std::vector<std::pair<std::string, std::array<Figure, 3>>> per_class;  ///< precision, recall, F1
  DelayTable press, slip;
  std::optional<DelayTable> true_press, true_slip, gross_slip;  ///< simulated runs
  std::vector<ReportedFalseAlarms> false_alarms;                ///< the network's first, then the trivial detectors'
  std::vector<OperatingPoint> operating_curve;
  std::optional<OperatingPoint> own_point;  ///< the network's own verdicts, without a threshold
  Calibration calibration;
  std::map<std::string, AccuracyOverTime> over_time;  ///< of "press", "slip" and "both"; what is not there was not measured
  bool is_beside = false;                             ///< the paper's own way, beside what the study reports: folded
};

/// A run over time, as a CSV of `tactile eval --run`.
struct ReportedRun {
  std::string run, model;
  double history_ms = 40;
  std::filesystem::path csv;
  std::filesystem::path outcome;  ///< how its intervals were met, as `tactile eval --run` writes it; may not be there
};

/// Objects seen beside the same held out, on one set of runs.
struct UnseenSection {
  std::string runs;  ///< in words; may be empty
  UnseenComparison comparison;
  bool is_beside = false;
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
  bool is_beside = false;
};

/// All that a report tells, from wherever it was read.
struct ReportInput {
  std::string title;
  bool simulated = false;
  std::string summary;  ///< may be empty
  std::vector<std::string> remarks;
  std::vector<Claim> claims;
  std::vector<ReportedTable> left_out;  ///< runs and intervals that are in no sample, and why
  std::vector<ReportedHistories> histories;
  std::vector<ReportedTable> choice;  ///< the best history of each object
  std::vector<ReportedEvaluation> evaluations;
  std::vector<ReportedRun> runs;
  std::vector<UnseenSection> unseen;
  std::vector<ReportedTable> splits;
  std::vector<TrainingCurve> trainings;
  std::optional<ReportedTrade> trade;  ///< of speed for accuracy
  std::vector<ReportedTable> settings;
  std::filesystem::path data;        ///< folder of runs; empty if not known
  double history_ms = 40;            ///< of the frames shown
  std::vector<std::string> missing;  ///< what is not there, and how to come by it
};

/// What a folder of `tactile reproduce` holds. Files that `study.json` names and that are not there are told as missing.
/// @throws Error  if study.json or a file that it names is there and not of its format
ReportInput read_study(const std::filesystem::path& folder);

/// What the folders of models hold of evaluations; the first is told whole, the others give their accuracies by history and their
/// trainings.
/// @param folders  of models, not empty
/// @param data     folder of runs for the frames; empty: none
/// @throws Error   if a model.json is missing, or a file is not of its format
ReportInput read_models(const std::vector<std::filesystem::path>& folders, const std::filesystem::path& data);

}  // namespace tactile
