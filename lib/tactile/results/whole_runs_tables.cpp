#include "tactile/results/whole_runs_tables.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "tactile/results/figure_text.hpp"

namespace tactile::results {
namespace {

std::string quantile_text(const CensoredQuantile& quantile, int decimals = 0) {
  return (quantile.is_lower_bound ? "> " : "") + figure_text(quantile.ms, 1, decimals);
}

std::string spaced(const std::string& text) { return text.empty() ? text : " " + text; }

std::string percent_text(const Figure& figure) {
  return value_text(figure, 100, 1) + " %" + spaced(interval_text(figure, 100, 1));
}

/// Also those that were in alarm since before their onset.
std::string missed_text(const OperatingPoint& point) {
  return fmt::format("{} of {}", point.misses + point.early, point.touches);
}

std::string lifts_text(const OperatingPoint& point) {
  return point.lifts == 0 ? "-" : fmt::format("{} of {}", point.lifts_with_slip, point.lifts);
}

std::string confirmed_text(const OperatingPoint& point) {
  std::string text = fmt::format("median {} ms, 90 % within {} ms", quantile_text(point.median_ms), quantile_text(point.p90_ms));
  if (point.lifts > 0) text += fmt::format("; in {} firm lifts", lifts_text(point));
  return text;
}

std::vector<std::string> row_of(const std::string& name, const OperatingPoint& point) {
  return {name,
          point.threshold ? fmt::format("{:g}", *point.threshold) : "-",
          figure_text(point.alarms_per_min, 1, 1),
          quantile_text(point.median_ms),
          quantile_text(point.p90_ms),
          value_text(point.gross_median_ms.ms, 1, 0),
          missed_text(point),
          value_text(point.wrong_class, 1, 3),
          lifts_text(point)};
}

}  // namespace

std::vector<std::pair<std::string, std::string>> lines_of(const WholeRuns& whole) {
  const OperatingPoint& point = whole.decided;
  constexpr std::size_t most_causes = 4;
  const TextTable all_causes = cause_table(whole);
  std::string causes;
  for (std::size_t i = 0; i < std::min(most_causes, all_causes.rows.size()); ++i)
    causes += fmt::format("{}{} {}", causes.empty() ? "" : ", ", all_causes.rows[i][0], all_causes.rows[i][1]);
  if (all_causes.rows.size() > most_causes) causes += ", ...";
  std::vector<std::pair<std::string, std::string>> lines{
      {"false alarms",
       fmt::format("{} a minute{}; in alarm {:.1f} % of the time outside of touches", value_text(point.alarms_per_min, 1, 1),
                   spaced(interval_text(point.alarms_per_min, 1, 1)), 100 * point.in_alarm)},
      {"delay", fmt::format("median {} ms, 90 % within {} ms; {} missed", quantile_text(point.median_ms),
                            quantile_text(point.p90_ms), missed_text(point))}};
  if (point.lifts > 0)
    lines.emplace_back("slip in firm lifts", fmt::format("{}, {}", lifts_text(point), percent_text(point.false_slips)));
  if (whole.confirmed && std::isfinite(whole.confirmed->median_ms.ms.value))
    lines.emplace_back("slip confirmed", confirmed_text(*whole.confirmed));
  if (!causes.empty()) lines.emplace_back("causes of alarms", causes);
  return lines;
}

TextTable calm_table(const WholeRuns& whole) {
  TextTable table{.caption =
                      "What fewer false alarms cost: two thresholds on the log-odds, moved until there are at most so many. "
                      "Missed: or in alarm since before the onset. Gross: median delay of slips from gross slip, negative "
                      "ahead of it. Wrong: episodes of the other class per touch. Lifts: those without slip in which slip is "
                      "reported",
                  .head = {"alarms/min", "threshold", "measured", "median [ms]", "90 %", "gross", "missed", "wrong", "lifts"},
                  .rows = {}};
  table.rows.push_back(row_of("as decided", whole.decided));
  for (const CalmPoint& calm : whole.calm) {
    const std::string name = fmt::format("at most {:g}", calm.at_most_per_min);
    if (calm.point) {
      table.rows.push_back(row_of(name, *calm.point));
    } else {
      table.rows.push_back({name, "none", "-", "-", "-", "-", "-", "-", "-"});
    }
  }
  return table;
}

TextTable confirmed_table(const WholeRuns& whole) {
  TextTable table{.caption =
                      "How sure a confirmed slip is, and what that costs: the log-odds that confirm a slip, its delay "
                      "from the first shear, slips that are never confirmed, and lifts without slip that are",
                  .head = {"confirmed from", "median [ms]", "90 % [ms]", "missed", "lifts", "alarms/min"},
                  .rows = {}};
  const auto add = [&](const std::string& name, const OperatingPoint& point) {
    table.rows.push_back({name, quantile_text(point.median_ms), quantile_text(point.p90_ms), missed_text(point),
                          lifts_text(point), figure_text(point.alarms_per_min, 1, 1)});
  };
  if (whole.confirmed) add("as decided", *whole.confirmed);
  for (const OperatingPoint& point : whole.confirmed_curve) {
    // Whole numbers are enough to read.
    if (point.threshold && std::floor(*point.threshold) == *point.threshold) add(fmt::format("{:g}", *point.threshold), point);
  }
  return table;
}

TextTable cause_table(const WholeRuns& whole) {
  TextTable table{
      .caption = "False alarms by what happened when they began", .head = {"cause", "alarms", "a minute"}, .rows = {}};
  std::vector<std::pair<std::string, std::uint64_t>> causes(whole.causes.begin(), whole.causes.end());
  std::stable_sort(causes.begin(), causes.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
  for (const auto& [cause, alarms] : causes)
    table.rows.push_back(
        {cause, std::to_string(alarms),
         whole.decided.outside_min > 0 ? fmt::format("{:.2f}", static_cast<double>(alarms) / whole.decided.outside_min) : "-"});
  return table;
}

TextTable object_table(const WholeRuns& whole) {
  TextTable table{.caption = "Each object, with the verdicts as they were decided",
                  .head = {"object", "alarms/min", "median [ms]", "90 % [ms]", "missed", "slip in firm lifts"},
                  .rows = {}};
  std::vector<std::pair<std::string, OperatingPoint>> objects(whole.objects.begin(), whole.objects.end());
  std::stable_sort(objects.begin(), objects.end(),
                   [](const auto& a, const auto& b) { return a.second.alarms_per_min.value > b.second.alarms_per_min.value; });
  for (const auto& [name, point] : objects)
    table.rows.push_back({name, figure_text(point.alarms_per_min, 1, 1), quantile_text(point.median_ms),
                          quantile_text(point.p90_ms), missed_text(point), lifts_text(point)});
  return table;
}

std::string runs_in_words(const WholeRuns& whole) {
  const std::size_t by_truth = whole.by_truth.size(), all = whole.runs.size();
  std::string text = fmt::format("{} whole run{}, ", all, all == 1 ? "" : "s");
  text += by_truth == all ? "judged by the truth."
          : by_truth == 0 ? "judged by their labels."
                          : fmt::format(
                                "{} judged by their truth, the others by their "
                                "labels.",
                                by_truth);
  return text + left_out_in_words(whole.left_out);
}

std::string left_out_in_words(std::span<const LeftOutRun> runs) {
  constexpr std::size_t most_named = 3;
  if (runs.empty()) return {};
  std::string text = fmt::format(" {} left out: ", runs.size() == 1 ? "1 run is" : fmt::format("{} runs are", runs.size()));
  for (std::size_t i = 0; i < std::min(most_named, runs.size()); ++i)
    text += fmt::format("{}{}, {}", i == 0 ? "" : "; ", runs[i].run, runs[i].why);
  return text + (runs.size() > most_named ? "; ..." : ".");
}

}  // namespace tactile::results
