#include "eval_summary.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "eval_tables.hpp"
#include "tactile/model/inference/two_thresholds.hpp"
#include "tactile/results/figure_text.hpp"
#include "text_table.hpp"

namespace tactile::cli {
namespace {

std::string spaced(const std::string& text) { return text.empty() ? text : " " + text; }

/// "94.6 % [91.3, 96.7]"
std::string percent_of(const results::Figure& figure) {
  return results::value_text(figure, 100, 1) + " %" + spaced(results::interval_text(figure, 100, 1));
}

std::string quantile_of(const results::CensoredQuantile& quantile) {
  return (quantile.is_lower_bound ? "more than " : "") + results::value_text(quantile.ms, 1, 1) + " ms";
}

std::string delay_of(const results::DelaySummary& delay) {
  if (delay.intervals == 0) return "no interval";
  return fmt::format("median {}{}, 90 % within {}; {} of {} missed{}", quantile_of(delay.median_of_all_ms),
                     spaced(results::interval_text(delay.median_of_all_ms.ms, 1, 1)), quantile_of(delay.quantile_of_all_ms),
                     delay.misses, delay.intervals, delay.early == 0 ? "" : fmt::format(", {} early", delay.early));
}

std::string rate_of(const results::Figure& per_min, const results::Figure& share, const char* where) {
  return fmt::format("{} per minute {}{}, {} % of that time", results::value_text(per_min, 1, 1), where,
                     spaced(results::interval_text(per_min, 1, 1)), results::value_text(share, 100, 1));
}

/// "boosted_trees", or "those of 3 of 6 baselines"
std::string baselines_not_below(const results::Evaluation& evaluation) {
  const auto is_not_below = [&](const results::BaselineScore& baseline) {
    return *baseline.accuracy.mean.high >= *evaluation.accuracy.mean.low;
  };
  const auto& all = evaluation.baselines;
  const auto count = std::count_if(all.begin(), all.end(), is_not_below);
  if (count == 1) return "that of " + std::find_if(all.begin(), all.end(), is_not_below)->name;
  return fmt::format("those of {} of {} baselines", count, all.size());
}

/// What a robot would meet, a line each.
std::vector<std::pair<std::string, std::string>> detector_lines(const results::Evaluation& evaluation) {
  const results::FalseAlarmTable& alarms = evaluation.network.false_alarms;
  return {{"press", delay_of(evaluation.network.press.all)},
          {"slip", delay_of(evaluation.network.slip.all)},
          {"false alarms", rate_of(alarms.outside_labels_per_min, alarms.outside_labels_share, "outside labels")},
          {"wrong class", rate_of(alarms.wrong_class_per_min, alarms.wrong_class_share, "of labels")},
          {"alarms counted", evaluation.counted_on()}};
}

/// Empty unless decisions over several ticks may help.
std::string advice_on_alarms(const results::Evaluation& evaluation) {
  constexpr double many_per_min = 10;
  const bool decides_over_ticks =
      evaluation.confirm != "1/1" || evaluation.alarm_cost.has_value() || !evaluation.thresholds.empty();
  const double per_min = evaluation.network.false_alarms.outside_labels_per_min.value;
  if (decides_over_ticks || !(per_min >= many_per_min)) return {};
  return "For fewer false alarms with a longer delay, try the default of 'detect': --thresholds " +
         text_of(model::TwoThresholds{}) + ".\n";
}

}  // namespace

std::string heading_of(const results::Evaluation& evaluation) {
  std::string heading = results::title_of(evaluation);
  if (evaluation.confirm != "1/1") heading += ", confirmed in " + evaluation.confirm + " ticks";
  if (evaluation.alarm_cost) heading += fmt::format(", filtered with an alarm cost of {:g}", *evaluation.alarm_cost);
  if (!evaluation.thresholds.empty()) heading += ", decided by the thresholds " + evaluation.thresholds;
  if (evaluation.gate_off) heading += ", gated";
  return heading;
}

std::string comparison_with_baselines(const results::Evaluation& evaluation) {
  const auto above = evaluation.above_baselines();
  if (evaluation.baselines.empty()) return "No baselines: the dataset has none of the runs that the model was trained on.";
  if (!above) return "No comparison with the baselines: too few objects for an interval.";
  if (*above) return "The model's accuracy interval lies above every baseline's.";
  return "The model's accuracy interval does not lie above " + baselines_not_below(evaluation) + ".";
}

std::string summary_of(const results::Evaluation& evaluation, const std::optional<evaluation::TickSpeed>& speed) {
  const results::Figure& accuracy = evaluation.accuracy.mean;
  std::vector<std::pair<std::string, std::string>> lines{
      {"accuracy", fmt::format("{}, mean over {} objects, {} runs", percent_of(accuracy), evaluation.accuracy.objects.size(),
                               evaluation.test_runs().size())}};
  const auto best = std::max_element(evaluation.baselines.begin(), evaluation.baselines.end(),
                                     [](const auto& a, const auto& b) { return a.accuracy.mean.value < b.accuracy.mean.value; });
  if (best != evaluation.baselines.end()) {
    lines.emplace_back("best baseline", fmt::format("{}, {}", percent_of(best->accuracy.mean), best->name));
  }
  const auto of_detector = detector_lines(evaluation);
  lines.insert(lines.end(), of_detector.begin(), of_detector.end());
  if (const auto& off = evaluation.gate_off; off && off->ticks > 0) {
    const double share = static_cast<double>(off->gated) / static_cast<double>(off->ticks);
    lines.emplace_back("gate", fmt::format("skips the model at {:.1f} % of {} ticks", 100 * share, off->ticks));
  }
  if (speed) {
    lines.emplace_back("time per tick", fmt::format("{:.0f} us in half of the ticks, {:.0f} us in 99 of 100, of one core",
                                                    speed->us_p50, speed->us_p99));
  }
  return wrapped(heading_of(evaluation)) + "\n\n" + text_list(lines) + wrapped(comparison_with_baselines(evaluation)) + "\n" +
         advice_on_alarms(evaluation) +
         "In brackets: 95 % intervals. --verbose prints all tables, --run fan/02 a run over time.\n";
}

std::string summary_of(const results::UnseenComparison& comparison, const results::Evaluation& held_out) {
  return text_of(comparison, held_out.simulated) + "\n" + text_list(detector_lines(held_out)) +
         "From press on: of models that never saw the objects. --verbose prints all tables.\n";
}

}  // namespace tactile::cli
