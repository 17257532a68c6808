#include "tactile/results/whole_runs_tables.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "tactile/results/figure_text.hpp"

namespace tactile::results {
namespace {

std::string spaced(const std::string& text) { return text.empty() ? text : " " + text; }

/// Also those that were in alarm since before their onset.
std::string missed_text(const OperatingPoint& point) {
  return fmt::format("{} of {}", point.misses + point.early, point.touches);
}

std::string lifts_text(const OperatingPoint& point) {
  return point.lifts == 0 ? "-" : fmt::format("{} of {}", point.lifts_with_slip, point.lifts);
}

std::string confirmed_text(const OperatingPoint& point) {
  std::string text = fmt::format("median {} ms, 90 % within {} ms", figure_text(point.median_ms), figure_text(point.p90_ms));
  if (point.lifts > 0) text += fmt::format("; in {} firm lifts", lifts_text(point));
  return text;
}

std::vector<std::string> row_of(const std::string& name, const OperatingPoint& point) {
  return {name,
          point.threshold ? fmt::format("{:g}", *point.threshold) : "-",
          figure_text(point.alarms_per_min, 1, 1),
          figure_text(point.median_ms),
          figure_text(point.p90_ms),
          value_text(point.gross_median_ms),
          missed_text(point),
          value_text(point.wrong_class, 1, 3),
          lifts_text(point)};
}

constexpr double compared_rate = 6;  // false alarms a minute at which detectors are compared

const OperatingPoint* compared_point(const std::vector<CalmPoint>& calm) {
  const auto found =
      std::find_if(calm.begin(), calm.end(), [](const CalmPoint& one) { return one.at_most_per_min == compared_rate; });
  return found != calm.end() && found->point ? &*found->point : nullptr;
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
       fmt::format("{} a minute{}; in alarm {} of the time outside of touches", value_text(point.alarms_per_min, 1, 1),
                   spaced(interval_text(point.alarms_per_min, 1, 1)), percent_text({.value = point.in_alarm}))},
      {"delay", fmt::format("median {} ms, 90 % within {} ms; {} missed", figure_text(point.median_ms), figure_text(point.p90_ms),
                            missed_text(point))}};
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
    table.rows.push_back({name, figure_text(point.median_ms), figure_text(point.p90_ms), missed_text(point), lifts_text(point),
                          figure_text(point.alarms_per_min, 1, 1)});
  };
  if (whole.confirmed) add("as decided", *whole.confirmed);
  for (const OperatingPoint& point : whole.confirmed_curve) {
    // Whole numbers are enough to read, up to the first that confirms hardly a slip.
    if (!point.threshold || std::floor(*point.threshold) != *point.threshold) continue;
    add(fmt::format("{:g}", *point.threshold), point);
    if (point.median_ms.is_lower_bound) break;
  }
  return table;
}

TextTable baseline_table(const WholeRuns& model, const std::map<std::string, Baseline>& baselines) {
  TextTable table{
      .caption = fmt::format("Published detectors, fitted to the same runs: a threshold on the event rate (Rigi et al. "
                             "2018), CUSUM of event counts (Page 1954), and a small network on features of events "
                             "(Funk et al. 2024). As decided, then calm: with at most {:g} false alarms a minute. "
                             "The first two know no classes, and get the true one",
                             compared_rate),
      .head = {"detector", "alarms/min", "median [ms]", "90 %", "missed", "calm: median", "90 %", "missed"},
      .rows = {}};
  if (baselines.empty()) return table;
  const auto add = [&](const std::string& name, const OperatingPoint& decided, const std::vector<CalmPoint>& calm) {
    std::vector<std::string> row{name, figure_text(decided.alarms_per_min, 1, 1), figure_text(decided.median_ms),
                                 figure_text(decided.p90_ms), missed_text(decided)};
    const OperatingPoint* point = compared_point(calm);
    for (const std::string& cell :
         point == nullptr ? std::vector<std::string>{"none", "-", "-"}
                          : std::vector{value_text(point->median_ms), value_text(point->p90_ms), missed_text(*point)})
      row.push_back(cell);
    table.rows.push_back(std::move(row));
  };
  add("this model", model.decided, model.calm);
  for (const auto& [name, baseline] : baselines) add(baseline_text(name), baseline.decided, baseline.calm);
  return table;
}

std::string baseline_text(const std::string& name) {
  return name == "event_rate" ? "event rate" : name == "cusum" ? "CUSUM" : "features";
}

std::optional<std::pair<std::string, OperatingPoint>> best_baseline(const std::map<std::string, Baseline>& baselines) {
  std::optional<std::pair<std::string, OperatingPoint>> best;
  for (const auto& [name, baseline] : baselines) {
    const OperatingPoint* point = compared_point(baseline.calm);
    if (point != nullptr && (!best || point->missed.value < best->second.missed.value)) best = {baseline_text(name), *point};
  }
  return best;
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
    table.rows.push_back({name, figure_text(point.alarms_per_min, 1, 1), figure_text(point.median_ms), figure_text(point.p90_ms),
                          missed_text(point), lifts_text(point)});
  return table;
}

std::string runs_in_words(const WholeRuns& whole) {
  const std::size_t by_truth = whole.by_truth.size(), all = whole.runs.size();
  std::string text = fmt::format("{} whole run{}, ", all, all == 1 ? "" : "s");
  text += by_truth == all ? "judged by the truth."
          : by_truth == 0 ? "judged by their labels."
                          : fmt::format("{} judged by their truth, the others by their labels.", by_truth);
  return text + left_out_in_words(whole.left_out);
}

std::string_view whole_runs_legend() {
  return "Every run counts, also firm lifts, those without a press or a slip, and those with flagged touches, which are left out "
         "themselves. A false alarm is an episode that begins outside of touches, whatever moves; it counts again for each "
         "further 500 ms. Wrong class: episodes that begin in a touch of the other class. Delays are over all touches: one that "
         "is missed, or in alarm since before its onset (early), is later than all others.";
}

std::string left_out_in_words(std::span<const LeftOutRun> runs) {
  constexpr std::size_t most_named = 3;
  std::size_t count = 0;
  std::string named, folders;
  for (const LeftOutRun& run : runs) {
    if (run.run.empty()) {
      folders += " " + run.why + ".";
    } else if (count++ < most_named) {
      named += fmt::format("{}{}, {}", named.empty() ? "" : "; ", run.run, run.why);
    }
  }
  if (count == 0) return folders;
  return fmt::format(" {} left out: {}{}", count == 1 ? "1 run is" : fmt::format("{} runs are", count), named,
                     count > most_named ? "; ..." : ".") +
         folders;
}

}  // namespace tactile::results
