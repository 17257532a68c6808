#include "eval_detection_tables.hpp"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "figure_text.hpp"
#include "tactile/core/text_lines.hpp"
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

constexpr const char* false_alarm_legend =
    "Outside labels: all episodes that begin outside labelled intervals, as one sees them in a laboratory. No unlabelled: the "
    "same without true motion that has no label; only in simulated runs. None in alarm: the share of press and slip among the "
    "ticks without motion, and not just after it. An episode counts again for each further 500 ms; a detector that stays on one "
    "class has few of them, and is in alarm all the time. Wrong class: episodes of "
    "another class that begin in a labelled interval, or last longer than the guard in it. The interval per minute is wider if "
    "there are few alarms in a short time.";

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

std::string false_alarms_text(const results::Evaluation& evaluation) {
  using results::FalseAlarmTable;
  Row header{"false alarms", "model", "95 %"};
  std::vector<const FalseAlarmTable*> others;
  const auto add = [&](const std::string& name, const FalseAlarmTable& table) {
    header.push_back(name);
    others.push_back(&table);
  };
  if (evaluation.truth) add("by truth", evaluation.truth->false_alarms);
  for (const auto& [name, score] : evaluation.trivial) add("(" + name + ")", score.false_alarms);
  const FalseAlarmTable& network = evaluation.network.false_alarms;
  std::vector<Row> rows;
  const auto add_row = [&](const std::string& name, results::Figure FalseAlarmTable::*figure, double scale) {
    Row row{name, number(scale * (network.*figure).value), bounds(network.*figure, scale)};
    for (const FalseAlarmTable* other : others) row.push_back(results::value_text(other->*figure, scale, 1));
    rows.push_back(row);
  };
  const results::FalseAlarms& total = network.total;
  add_row("outside labels [1/min]", &FalseAlarmTable::outside_labels_per_min, 1);
  add_row("  in alarm [% of time]", &FalseAlarmTable::outside_labels_share, 100);
  add_row("no unlabelled [1/min]", &FalseAlarmTable::outside_motion_per_min, 1);
  add_row("  in alarm [% of time]", &FalseAlarmTable::outside_motion_share, 100);
  add_row("none in alarm [%]", &FalseAlarmTable::none_in_alarm_share, 100);
  add_row("wrong class [1/min]", &FalseAlarmTable::wrong_class_per_min, 1);
  add_row("  wrong [% of time]", &FalseAlarmTable::wrong_class_share, 100);
  const std::string outside_motion =
      total.outside_motion_time == microseconds{0}
          ? "unlabelled motion is known in simulated runs only"
          : fmt::format("no unlabelled: {} in {:.3f} min", total.outside_motion, results::in_minutes(total.outside_motion_time));
  const std::string times =
      fmt::format("Outside labels: {} in {:.3f} min; {}; none: {:.3f} min; labels: {} in {:.3f} min. ", total.outside_labels,
                  results::in_minutes(total.outside_labels_time), outside_motion, results::in_minutes(total.none_time),
                  total.wrong_class, results::in_minutes(total.labelled_time));
  return text_table(header, rows) + wrapped(evaluation.runs_counted() + " " + times + false_alarm_legend) + "\n\n";
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
  if (!evaluation.with_flagged) return text + "No label is flagged.\n\n";
  const results::WithFlagged& with = *evaluation.with_flagged;
  rows = {{"accuracy [%]", percent(evaluation.accuracy.mean), percent(with.accuracy), bounds(with.accuracy, 100)}};
  for (const auto& [name, without, flagged] : {std::tuple("press", &press, &with.press), std::tuple("slip", &slip, &with.slip)}) {
    rows.push_back({fmt::format("median of all of {} [ms]", name), quantile_text(without->median_of_all_ms),
                    quantile_text(flagged->median_of_all_ms), bounds(flagged->median_of_all_ms.ms, 1)});
    rows.push_back({fmt::format("mean delay of {} [ms]", name), number(without->mean_ms), number(flagged->mean_ms),
                    bounds(flagged->mean_ms, 1)});
    rows.push_back({fmt::format("{}, misses + early of all", name),
                    fmt::format("{} of {}", misses_and_early(*without), without->intervals),
                    fmt::format("{} of {}", misses_and_early(*flagged), flagged->intervals)});
  }
  return text + text_table({"with flagged labels", "without", "with", "95 %"}, rows) +
         wrapped(fmt::format("With {} flagged run{} that the dataset leaves out, and {} flagged interval{} of the others.",
                             with.runs.size(), with.runs.size() == 1 ? "" : "s", with.intervals,
                             with.intervals == 1 ? "" : "s")) +
         "\n\n";
}

}  // namespace tactile::cli
