#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "live_line.hpp"
#include "tactile/capture/run_recorder.hpp"
#include "tactile/capture/session_plan.hpp"

namespace tactile {

/// What to record into which folder.
struct RunsToRecord {
  std::filesystem::path data;
  SessionPlan plan;
  bool is_session = false;  ///< walks the plan and asks before each run; else it is one run of the plan's one object
  std::string run;          ///< of a single run; the next free number if it is empty
  nlohmann::json settings;
};

struct RecordedRuns {
  std::vector<RunSummary> runs;
  std::string error;  ///< what ended them, in the last run or behind it; empty if all went well
};

/// Records until the plan is fulfilled, the user or the sources end it, or something fails. Answers come from standard input, a
/// line each; questions and the live line go to stderr.
RecordedRuns record_runs(RunRecorder& recorder, const RunsToRecord& wanted, LiveLine& line);

std::string text_of(const RunSummary& run);
nlohmann::json json_of(const RunSummary& run);

}  // namespace tactile
