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

constexpr double shown_ms[] = {0, 10, 20, 50, 100, 200, 500};  // eval.json has more

constexpr const char* curve_legend =
    "Kaplan-Meier: a missed interval counts as undetected until its end, at most 500 ms. 0 ms: predicted ahead of the onset. "
    "median, 90 %: the time within which half and 90 % of all intervals are detected; \u2265: the true time is longer, because "
    "misses are below it. early: predicted more than 10 ms ahead of the onset; head start: less. In brackets: trivial detectors, "
    "which ignore the events. They are fast by chance, at the price of false alarms.";

constexpr const char* delay_legend =
    "The best possible delay is one tick. Mean and median here are over detected intervals, as in the paper: misses and early "
    "ones "
    "are left out. sem: standard error of the mean; -: too few intervals. From gross slip: below 0 where slip is predicted "
    "before "
    "it.";

constexpr const char* whole_legend =
    "Every run counts, also firm lifts, those without a press or a slip, and flagged ones. A false alarm is an episode that "
    "begins "
    "outside of touches, whatever moves; it counts again for each further 500 ms. Wrong class: episodes that begin in a touch of "
    "the other class. Delays are over all touches: one that is missed, or in alarm since before its onset (early), is later than "
    "all others.";

constexpr const char* labels_legend =
    "Onsets and ends are drawn {} times from their own 95 % intervals in labels.json. labels alone: the middle 95 % of these "
    "draws, "
    "of the same runs. both: the interval over runs, to which their spread is added.";

std::string quantile_text(const results::CensoredQuantile& quantile) {
  return (quantile.is_lower_bound ? "\u2265 " : "") + number(quantile.ms);
}

/// The network by labels and by the truth, and the trivial detectors.
std::vector<NamedTable> tables_of(const results::Evaluation& evaluation, Touch touch) {
  const auto of = [touch](const auto& score) { return touch == Touch::press ? &score.press : &score.slip; };
  std::vector<NamedTable> tables{{std::string(name_of(touch)), of(evaluation.network)}};
  if (evaluation.truth) tables.emplace_back("  from true onset", of(*evaluation.truth));
  if (evaluation.truth && touch == Touch::slip) tables.emplace_back("  from gross slip", &evaluation.truth->gross_slip);
  for (const auto& [name, score] : evaluation.trivial) tables.emplace_back("  (" + name + ")", of(score));
  return tables;
}

std::string curve_text(const results::Evaluation& evaluation) {
  Row header{"detected [%]"};
  for (const double ms : shown_ms) header.push_back(fmt::format("{:g} ms", ms));
  std::vector<Row> rows;
  for (const Touch touch : {Touch::press, Touch::slip}) {
    for (const auto& [name, table] : tables_of(evaluation, touch)) {
      Row values{name}, intervals{"  95 %"};
      for (const double ms : shown_ms) {
        const auto point = std::find_if(table->curve.begin(), table->curve.end(),
                                        [ms](const results::DetectedWithin& one) { return one.ms == ms; });
        const results::Figure share = point == table->curve.end() ? results::Figure{} : point->share;
        values.push_back(results::value_text(share, 100, 1));
        const std::string interval = results::interval_text(share, 100, 0);
        intervals.push_back(interval.empty() ? "-" : interval);
      }
      rows.push_back(values);
      if (table == &evaluation.network.press || table == &evaluation.network.slip) rows.push_back(intervals);
    }
  }
  return text_table(header, rows) + "\n";
}

std::string all_intervals_text(const results::Evaluation& evaluation) {
  std::vector<Row> counts, quantiles;
  for (const Touch touch : {Touch::press, Touch::slip}) {
    for (const auto& [name, table] : tables_of(evaluation, touch)) {
      const results::DelaySummary& all = table->all;
      counts.push_back({name, std::to_string(all.intervals), std::to_string(all.misses), percent(all.missed),
                        bounds(all.missed, 100), std::to_string(all.early), std::to_string(all.head_starts)});
      quantiles.push_back({name, quantile_text(all.median_of_all_ms), bounds(all.median_of_all_ms.ms, 1),
                           quantile_text(all.quantile_of_all_ms), bounds(all.quantile_of_all_ms.ms, 1)});
    }
  }
  return text_table({"all intervals", "of", "misses", "[%]", "95 %", "early", "head start"}, counts) + "\n" +
         text_table({"delay of all intervals [ms]", "median", "95 %", "90 %", "95 %"}, quantiles) + wrapped(curve_legend) +
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
  return curve_text(evaluation) + all_intervals_text(evaluation) + paper_delays_text(evaluation, Touch::press) +
         paper_delays_text(evaluation, Touch::slip) + wrapped(delay_legend) + "\n\n";
}

std::string whole_runs_text(const results::Evaluation& evaluation) {
  const results::WholeRuns& whole = evaluation.whole_runs;
  std::string text;
  for (const results::TextTable& table :
       {results::calm_table(whole), results::confirmed_table(whole), results::cause_table(whole), results::object_table(whole)}) {
    if (!table.rows.empty()) text += wrapped(table.caption + ":") + "\n" + text_table(table.head, table.rows) + "\n";
  }
  return text + wrapped(results::runs_in_words(whole) + " " + whole_legend) + "\n\n";
}

std::string labels_text(const results::Evaluation& evaluation) {
  const results::LabelUncertainty& uncertainty = evaluation.label_uncertainty;
  const results::DelaySummary &press = evaluation.network.press.all, &slip = evaluation.network.slip.all;
  std::vector<Row> rows;
  const auto add = [&](const std::string& name, const results::Figure& labelled, const results::SpreadByLabels& spread,
                       double scale) {
    rows.push_back({name, number(scale * labelled.value), bounds(labelled, scale), number(scale * spread.mean),
                    std::isfinite(spread.low) ? fmt::format("[{:.2f}, {:.2f}]", scale * spread.low, scale * spread.high) : "-",
                    bounds(spread.with_runs, scale)});
  };
  std::string text;
  if (uncertainty.draws > 0) {
    add("accuracy [%]", evaluation.accuracy.mean, uncertainty.accuracy, 100);
    add("mean delay of press [ms]", press.mean_ms, uncertainty.press_mean_ms, 1);
    add("median of all presses [ms]", press.median_of_all_ms.ms, uncertainty.press_median_ms, 1);
    add("mean delay of slip [ms]", slip.mean_ms, uncertainty.slip_mean_ms, 1);
    add("median of all slips [ms]", slip.median_of_all_ms.ms, uncertainty.slip_median_ms, 1);
    text = text_table({"uncertainty of labels", "as labelled", "95 %, runs", "drawn labels", "95 %, labels alone", "95 %, both"},
                      rows) +
           wrapped(fmt::format(fmt::runtime(labels_legend), uncertainty.draws)) + "\n\n";
  }
  return text;
}

}  // namespace tactile::cli
