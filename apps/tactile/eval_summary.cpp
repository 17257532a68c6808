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

std::string heading_of(const results::Evaluation& evaluation) {
  std::string heading = results::title_of(evaluation);
  if (evaluation.onset == "visible") heading += ", from visible onsets";
  if (evaluation.confirm != "1/1") heading += ", confirmed in " + evaluation.confirm + " ticks";
  if (!evaluation.thresholds.empty()) heading += ", decided by the thresholds " + evaluation.thresholds;
  return heading;
}

std::string summary_of(const results::Evaluation& evaluation, const std::optional<evaluation::TickSpeed>& speed) {
  const results::Figure& accuracy = evaluation.accuracy.mean;
  auto lines = results::lines_of(evaluation.whole_runs);
  lines.emplace_back("accuracy",
                     fmt::format("{} on balanced samples, mean over {} objects, {} runs", results::percent_text(accuracy),
                                 evaluation.accuracy.objects.size(), evaluation.test_runs().size()));
  if (const auto best = results::best_baseline(evaluation.baselines)) {
    const auto& [name, point] = *best;
    lines.emplace_back("best baseline",
                       fmt::format("{}, with {} false alarms a minute: median {} ms, {} of {} missed", name,
                                   results::value_text(point.alarms_per_min, 1, 1), results::value_text(point.median_ms),
                                   point.misses + point.early, point.touches));
  }
  if (speed) {
    lines.emplace_back("time per tick", fmt::format("{:.0f} us in half of the ticks, {:.0f} us in 99 of 100, of one core",
                                                    speed->us_p50, speed->us_p99));
  }
  const results::TextTable calm = results::calm_table(evaluation.whole_runs);
  return wrapped(heading_of(evaluation)) + "\n\n" + text_list(lines) + "\n" + text_table(calm.head, calm.rows) + "\n" +
         wrapped(results::runs_in_words(evaluation.whole_runs)) +
         "\nIn brackets: 95 % intervals. --verbose prints all tables, --run fan/02 a run over time.\n";
}

std::string summary_of(const results::UnseenComparison& comparison, const results::Evaluation& held_out) {
  const results::TextTable calm = results::calm_table(held_out.whole_runs);
  return text_of(comparison, held_out.simulated) + "\nOf models that never saw the objects:\n\n" +
         text_list(results::lines_of(held_out.whole_runs)) + "\n" + text_table(calm.head, calm.rows) + "\n" +
         wrapped(results::runs_in_words(held_out.whole_runs)) + "\n--verbose prints all tables.\n";
}

}  // namespace tactile::cli
