#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tactile/evaluation/confidence_interval.hpp"
#include "tactile/study/claims.hpp"
#include "tactile/study/history_choice.hpp"
#include "tactile/study/step_runner.hpp"

namespace tactile {

/// {"name", "version", "revision", "libtorch"}: what measured.
nlohmann::json software_json();

/// {"cpu", "system", "cores", "memory_bytes", "threads"}: what it measured on, with how many threads.
nlohmann::json machine_json(unsigned threads);

/// {"name", "command", "seconds", "finished_at"} of each; "command" null where there is none.
nlohmann::json steps_json(std::span<const StepRecord> steps);

/// `path` as counted from a study's folder, whether it is there yet or not.
std::string from_folder(const std::filesystem::path& path, const std::filesystem::path& folder);

/// How the intervals of each run were met: "runs" of an evaluation. @throws Error, naming `where`, if it has none
std::vector<RunDetections> detections_in(const nlohmann::json& evaluation, const std::string& where);

/// Which objects had every slip told at the first tick: none missed, none early, and a mean of one tick.
std::map<std::string, bool> told_at_once(const std::map<std::string, DelaySummary>& delays, double tick_ms);

/// Accuracies on one set of runs, for a table.
struct AccuracyRow {
  double history_ms = 0;
  std::string runs;  ///< "choice", "reported", "all_test"
  const Accuracy* accuracy = nullptr;
};

/// th_ms,runs,object,value,low,high,n; the mean over objects as object "all".
std::string accuracy_csv(const std::vector<AccuracyRow>& rows);

struct UnseenRow {
  std::string split, runs;
  UnseenComparison comparison;
};

/// split,runs,object,of,value,low,high,n
std::string unseen_csv(const std::vector<UnseenRow>& rows);

/// id,runs,value,low,high,n,unit,asked,limit,kept,of,verdict
std::string claims_csv(const std::vector<Claim>& claims);

}  // namespace tactile
