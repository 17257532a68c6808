#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "live_line.hpp"
#include "record_choices.hpp"
#include "tactile/capture/run_recorder.hpp"
#include "tactile/capture/session_plan.hpp"

namespace tactile::cli {

/// What is recorded at a moment.
struct RecordMoment {
  const char* state = "waiting";           ///< "waiting" for a run to begin, or "recording" one
  std::string run{};                       ///< "fan/03"; empty while waiting
  std::string words{};                     ///< what is waited for, or how the run ends
  const capture::RunState* now = nullptr;  ///< of a run that is recorded
  const capture::RunRecorder* recorder = nullptr;
};

/// The runs to record.
struct RunsToRecord {
  std::filesystem::path data;
  capture::SessionPlan plan;
  bool is_session = false;  ///< follows the plan and asks before each run; else one run of the plan's only object
  std::string run;          ///< of a single run; empty: the next free number
  nlohmann::json settings;
  std::function<void(const RecordMoment&)> watch = {};  ///< called again and again; must return soon
  PageChoices* choices = nullptr;                       ///< of a page; null: there is none
};

struct RecordedRuns {
  std::vector<capture::RunSummary> runs;
  std::string error;  ///< the error that ended the last run, or came after it; empty if there was none
};

/// Records until the plan is complete, the user or the sources end it, or an error occurs. Choices are lines of standard input,
/// and those of the page. Questions and the live line go to stderr.
RecordedRuns record_runs(capture::RunRecorder& recorder, const RunsToRecord& wanted, LiveLine& line);

std::string text_of(const capture::RunSummary& run);
nlohmann::json json_of(const capture::RunSummary& run);

}  // namespace tactile::cli
