#include "eval_summary.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "eval_tables.hpp"
#include "tactile/results/figure_text.hpp"
#include "tactile/results/whole_runs_tables.hpp"
#include "text_table.hpp"

namespace tactile::cli {
namespace {

std::string spaced(const std::string& text) { return text.empty() ? text : " " + text; }

/// "94.6 % [91.3, 96.7]"
std::string percent_of(const results::Figure& figure) {
  return results::value_text(figure, 100, 1) + " %" + spaced(results::interval_text(figure, 100, 1));
}

/// "event_count", or "those of 2 of 3 baselines"
std::string baselines_not_below(const results::Evaluation& evaluation) {
  const auto is_not_below = [&](const results::BaselineScore& baseline) {
    return *baseline.accuracy.mean.high >= *evaluation.accuracy.mean.low;
  };
  const auto& all = evaluation.baselines;
  const auto count = std::count_if(all.begin(), all.end(), is_not_below);
  if (count == 1) return "that of " + std::find_if(all.begin(), all.end(), is_not_below)->name;
  return fmt::format("those of {} of {} baselines", count, all.size());
}

}  // namespace

std::string heading_of(const results::Evaluation& evaluation) {
  std::string heading = results::title_of(evaluation);
  if (evaluation.confirm != "1/1") heading += ", confirmed in " + evaluation.confirm + " ticks";
  if (!evaluation.thresholds.empty()) heading += ", decided by the thresholds " + evaluation.thresholds;
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
  auto lines = results::lines_of(evaluation.whole_runs);
  lines.emplace_back("accuracy", fmt::format("{} on balanced samples, mean over {} objects, {} runs", percent_of(accuracy),
                                             evaluation.accuracy.objects.size(), evaluation.test_runs().size()));
  const auto best = std::max_element(evaluation.baselines.begin(), evaluation.baselines.end(),
                                     [](const auto& a, const auto& b) { return a.accuracy.mean.value < b.accuracy.mean.value; });
  if (best != evaluation.baselines.end()) {
    lines.emplace_back("best baseline", fmt::format("{}, {}", percent_of(best->accuracy.mean), best->name));
  }
  if (speed) {
    lines.emplace_back("time per tick", fmt::format("{:.0f} us in half of the ticks, {:.0f} us in 99 of 100, of one core",
                                                    speed->us_p50, speed->us_p99));
  }
  const results::TextTable calm = results::calm_table(evaluation.whole_runs);
  return wrapped(heading_of(evaluation)) + "\n\n" + text_list(lines) + "\n" + text_table(calm.head, calm.rows) + "\n" +
         wrapped(results::runs_in_words(evaluation.whole_runs)) + "\n" + wrapped(comparison_with_baselines(evaluation)) +
         "\nIn brackets: 95 % intervals. --verbose prints all tables, --run fan/02 a run over time.\n";
}

std::string summary_of(const results::UnseenComparison& comparison, const results::Evaluation& held_out) {
  const results::TextTable calm = results::calm_table(held_out.whole_runs);
  return text_of(comparison, held_out.simulated) + "\nOf models that never saw the objects:\n\n" +
         text_list(results::lines_of(held_out.whole_runs)) + "\n" + text_table(calm.head, calm.rows) + "\n" +
         wrapped(results::runs_in_words(held_out.whole_runs)) + "\n--verbose prints all tables.\n";
}

}  // namespace tactile::cli
