#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "labelled_run.hpp"

namespace tactile::cli {

/// A flag stands on the run or one of its intervals.
bool is_flagged(const LabelledRun& labelled);

/// A row for each run: its first press and slip, the lag from lift to slip, the robot's clock, and how many flags stand. What the
/// flags say follows.
/// @param with_methods  also what each clock was found by
std::string runs_table(const std::vector<LabelledRun>& runs, bool with_methods);
/// The remarks that need no check, each with its runs; empty if there are none.
std::string remarks_text(const std::vector<LabelledRun>& runs);
nlohmann::json runs_json(const std::vector<LabelledRun>& runs);

/// For each object: its runs, how many of them are flagged, and the lag from lift to slip as it was measured.
std::string objects_table(const std::vector<LabelledRun>& runs);
nlohmann::json objects_json(const std::vector<LabelledRun>& runs);

/// How far apart two sources put the same onsets, and which clocks that rests on.
std::string differences_table(const std::vector<LabelledRun>& runs);
nlohmann::json differences_json(const std::vector<LabelledRun>& runs);

}  // namespace tactile::cli
