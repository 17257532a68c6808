#include "tactile/experiments/stress/stress_figures.hpp"

#include <algorithm>

#include "tactile/core/error.hpp"
#include "tactile/core/parallel.hpp"
#include "tactile/evaluation/accuracy.hpp"
#include "tactile/evaluation/run_figures.hpp"
#include "tactile/evaluation/whole_runs.hpp"

namespace tactile::stress {
namespace {

bool has_samples(std::span<const results::Cell> outcomes) {
  return std::any_of(outcomes.begin(), outcomes.end(),
                     [](const results::Cell& outcome) { return outcome.samples.samples() > 0; });
}

void check_same_runs(std::span<const std::vector<results::Cell>> outcomes) {
  for (const std::vector<results::Cell>& at : outcomes) {
    bool same = at.size() == outcomes.front().size();
    for (std::size_t i = 0; same && i < at.size(); ++i) {
      const results::Cell& first = outcomes.front()[i];
      same = at[i].object == first.object && at[i].run == first.run && at[i].training == first.training;
    }
    if (!same) throw Error("stress: different runs at different severities; expected the same ones in the same order");
  }
}

}  // namespace

results::StressPoint point_of(std::span<const results::Cell> outcomes, const results::BootstrapOptions& options) {
  results::StressPoint point;
  point.accuracy = evaluation::accuracy_of(outcomes, options).mean;
  if (!outcomes.empty()) point.whole = evaluation::operating_point(outcomes, options);
  return point;
}

std::optional<double> severity_where_lost(std::span<const double> severities, std::span<const double> accuracies,
                                          double most_lost) {
  constexpr double rounding = 1e-12;  // shares of samples are sums of few numbers
  if (accuracies.empty()) return std::nullopt;
  const double limit = accuracies.front() - most_lost;
  for (std::size_t i = 1; i < accuracies.size(); ++i) {
    if (accuracies[i] >= limit - rounding) continue;
    const double before = accuracies[i - 1] - limit, beyond = limit - accuracies[i];
    return severities[i - 1] + (severities[i] - severities[i - 1]) * std::max(0.0, before) / (std::max(0.0, before) + beyond);
  }
  return std::nullopt;
}

std::optional<results::HoldsUpTo> holds_up_to(std::span<const double> severities,
                                              std::span<const std::vector<results::Cell>> outcomes, double most_lost,
                                              const results::BootstrapOptions& options) {
  if (outcomes.empty() || !has_samples(outcomes.front())) return std::nullopt;
  check_same_runs(outcomes);
  const std::vector<results::Cell>& harmless = outcomes.front();
  const auto lost_in = [&](const evaluation::RunsByObject& chosen) {
    std::vector<double> accuracies;
    for (const std::vector<results::Cell>& at : outcomes) {
      const evaluation::Statistic accuracy = evaluation::mean_over_objects([&](std::span<const std::size_t> indexes) {
        results::Confusion sum;
        for (const std::size_t i : indexes) sum += at[i].samples;
        return sum.accuracy();
      });
      const std::optional<double> mean = accuracy(chosen);
      if (!mean) return std::optional<double>();
      accuracies.push_back(*mean);
    }
    const std::optional<double> lost = severity_where_lost(severities, accuracies, most_lost);
    return std::optional(lost.value_or(severities.back()));
  };
  const evaluation::RunFigures figures(std::span<const results::Cell>(harmless), &options, evaluation::has_samples);
  results::HoldsUpTo holds{.severity = figures.of_objects(lost_in)};
  for (std::optional<double>* bound : {&holds.severity.low, &holds.severity.high}) {
    if (*bound) *bound = std::clamp(**bound, severities.front(), severities.back());
  }
  holds.is_beyond = holds.severity.value >= severities.back();
  return holds;
}

std::vector<results::StressPoint> points_of(std::span<const double> severities,
                                            std::span<const std::vector<results::Cell>> outcomes, unsigned threads,
                                            const results::BootstrapOptions& options) {
  check_same_runs(outcomes);
  std::vector<results::StressPoint> points(outcomes.size());
  parallel_for(points.size(), threads, [&](std::size_t i) {
    points[i] = point_of(outcomes[i], options);
    points[i].severity = severities[i];
    if (i > 0 && has_samples(outcomes[i]))
      points[i].accuracy_change = evaluation::accuracy_difference(outcomes.front(), outcomes[i], options).mean;
  });
  return points;
}

}  // namespace tactile::stress
