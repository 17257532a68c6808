#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tactile/results/whole_runs.hpp"

namespace tactile::results {

// What a terminal, a report and a page print of whole runs.

/// A table of words. The first cell of a row names it.
struct TextTable {
  std::string caption{};
  std::vector<std::string> head{};
  std::vector<std::vector<std::string>> rows{};
};

/// What a robot would meet with the verdicts as they were decided: names and figures in words.
std::vector<std::pair<std::string, std::string>> lines_of(const WholeRuns& whole);

/// A row for the verdicts as they were decided, and one for each rate of false alarms: what fewer of them cost.
TextTable calm_table(const WholeRuns& whole);

/// A row for the slips as they were confirmed, and one for each whole number of log-odds that could confirm them.
TextTable confirmed_table(const WholeRuns& whole);

/// The model and each baseline: as decided, and where they have at most 6 false alarms a minute.
TextTable baseline_table(const WholeRuns& model, const std::map<std::string, Baseline>& baselines);

/// "event rate", "CUSUM", "features"
std::string baseline_text(const std::string& name);

/// The baseline that misses least where it has at most 6 false alarms a minute; none where none has so few.
std::optional<std::pair<std::string, OperatingPoint>> best_baseline(const std::map<std::string, Baseline>& baselines);

/// False alarms of the verdicts as they were decided, by cause: the most frequent first.
TextTable cause_table(const WholeRuns& whole);

/// The verdicts as they were decided, on each object: the one with the most false alarms first.
TextTable object_table(const WholeRuns& whole);

/// "98 runs, 90 judged by their truth, the others by their labels. 2 runs are left out: fan/03, it has no labels; ..."
std::string runs_in_words(const WholeRuns& whole);

/// What counts, for whom reads the tables.
std::string_view whole_runs_legend();

/// " 2 runs are left out: fan/03, it has no labels; mug/01, ..."; empty if there are none.
std::string left_out_in_words(std::span<const LeftOutRun> runs);

}  // namespace tactile::results
