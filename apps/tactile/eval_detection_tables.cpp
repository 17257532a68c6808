#include "eval_detection_tables.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "figure_text.hpp"
#include "tactile/core/text_lines.hpp"
#include "tactile/results/whole_runs_tables.hpp"
#include "text_table.hpp"

namespace tactile::cli {
namespace {

using Row = std::vector<std::string>;
using NamedTable = std::pair<std::string, const results::DelayTable*>;

constexpr const char* quantile_legend =
    "median, 90 %: the time within which half and 90 % of all touches are detected; > the true time is longer, because misses "
    "are below it. early: predicted more than 10 ms ahead of the onset. In brackets: trivial detectors, which ignore the "
    "events. They are fast by chance, at the price of false alarms.";

constexpr const char* delay_legend =
    "The best possible delay is one tick. Mean and median here are over detected intervals, as in the paper: misses and early "
    "ones are left out. sem: standard error of the mean; -: too few touches.";

/// The network by labels and by the truth, and the trivial detectors.
std::vector<NamedTable> tables_of(const results::Evaluation& evaluation, Touch touch) {
  const auto of = [touch](const auto& score) { return touch == Touch::press ? &score.press : &score.slip; };
  std::vector<NamedTable> tables{{std::string(name_of(touch)), of(evaluation.network)}};
  if (evaluation.truth) tables.emplace_back("  from true onset", of(evaluation.truth->delay_ms));
  for (const auto& [name, score] : evaluation.trivial) tables.emplace_back("  (" + name + ")", of(score));
  return tables;
}

std::string all_intervals_text(const results::Evaluation& evaluation) {
  std::vector<Row> counts, quantiles;
  for (const Touch touch : {Touch::press, Touch::slip}) {
    for (const auto& [name, table] : tables_of(evaluation, touch)) {
      const results::DelaySummary& all = table->all;
      counts.push_back({name, std::to_string(all.intervals), std::to_string(all.misses), percent(all.missed),
                        bounds(all.missed, 100), std::to_string(all.early)});
      quantiles.push_back({name, results::value_text(all.median_of_all_ms), bounds(all.median_of_all_ms.ms, 1),
                           results::value_text(all.quantile_of_all_ms), bounds(all.quantile_of_all_ms.ms, 1)});
    }
  }
  return text_table({"all intervals", "of", "misses", "[%]", "95 %", "early"}, counts) + "\n" +
         text_table({"delay of all intervals [ms]", "median", "95 %", "90 %", "95 %"}, quantiles) + wrapped(quantile_legend) +
         "\n\n";
}

Row delay_row(const std::string& name, const results::DelaySummary& delay) {
  return {name,
          number(delay.mean_ms),
          bounds(delay.mean_ms, 1),
          number(delay.sem_ms),
          number(delay.median_ms),
          std::to_string(delay.intervals),
          std::to_string(delay.misses),
          std::to_string(delay.early)};
}

std::string paper_delays_text(const results::Evaluation& evaluation, Touch touch) {
  std::vector<Row> rows;
  for (const auto& [name, table] : tables_of(evaluation, touch)) {
    if (rows.empty()) {
      for (const auto& [object, delay] : table->objects) rows.push_back(delay_row(object, delay));
      rows.push_back(delay_row("all", table->all));
    } else {
      rows.push_back(delay_row(name, table->all));
    }
  }
  return text_table(
             {fmt::format("detected {}, delay [ms]", name_of(touch)), "mean", "95 %", "sem", "median", "of", "misses", "early"},
             rows) +
         "\n";
}

}  // namespace

std::string delays_text(const results::Evaluation& evaluation) {
  return all_intervals_text(evaluation) + paper_delays_text(evaluation, Touch::press) +
         paper_delays_text(evaluation, Touch::slip) + wrapped(delay_legend) + "\n\n";
}

std::string whole_runs_text(const results::Evaluation& evaluation) {
  const results::WholeRuns& whole = evaluation.whole_runs;
  std::string text;
  for (const results::TextTable& table :
       {results::calm_table(whole), results::confirmed_table(whole), results::baseline_table(whole, evaluation.baselines),
        results::cause_table(whole), results::object_table(whole)}) {
    if (!table.rows.empty()) text += wrapped(table.caption + ":") + "\n" + text_table(table.head, table.rows) + "\n";
  }
  return text + wrapped(fmt::format("{} {}", results::runs_in_words(whole), results::whole_runs_legend())) + "\n\n";
}

}  // namespace tactile::cli
