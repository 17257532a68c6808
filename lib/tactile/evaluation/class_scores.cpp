#include "tactile/evaluation/class_scores.hpp"

#include <functional>
#include <optional>

#include "tactile/evaluation/accuracy.hpp"

namespace tactile::evaluation {
namespace {

using CountsOfClass = std::function<std::optional<double>(double right, double predicted, double occurs)>;

std::optional<double> share(double part, double of) { return of > 0 ? std::optional(part / of) : std::nullopt; }

Statistic statistic_of(std::span<const results::RunConfusion> runs, std::size_t touch, CountsOfClass value) {
  return [runs, touch, value = std::move(value)](const RunsByObject& chosen) {
    std::uint64_t right = 0, predicted = 0, occurs = 0;
    for (const auto& object : chosen) {
      for (const std::size_t i : object) {
        const auto& counts = runs[i].confusion.counts;
        right += counts[touch][touch];
        for (std::size_t other = 0; other < touch_count; ++other) {
          predicted += counts[other][touch];
          occurs += counts[touch][other];
        }
      }
    }
    return value(static_cast<double>(right), static_cast<double>(predicted), static_cast<double>(occurs));
  };
}

template <class MakeFigure>
std::array<results::ClassScore, touch_count> scores_of(std::span<const results::RunConfusion> runs, MakeFigure figure) {
  std::array<results::ClassScore, touch_count> scores;
  for (std::size_t touch = 0; touch < touch_count; ++touch) {
    const auto of = [&](CountsOfClass value) { return figure(statistic_of(runs, touch, std::move(value))); };
    scores[touch].precision = of([](double right, double predicted, double) { return share(right, predicted); });
    scores[touch].recall = of([](double right, double, double occurs) { return share(right, occurs); });
    scores[touch].f1 = of([](double right, double predicted, double occurs) { return share(2 * right, predicted + occurs); });
  }
  return scores;
}

}  // namespace

results::ClassScores class_scores_of(std::span<const results::RunConfusion> runs, const results::BootstrapOptions& options) {
  const auto objects = results_by_object(runs, [](const results::RunConfusion& run) { return run.confusion.samples() > 0; });
  const Range range = range_of_shares(runs);
  results::ClassScores scores;
  for (const auto& [name, cells] : objects) {
    scores.objects[name] =
        scores_of(runs, [&, &of = cells](const Statistic& statistic) { return figure_of_object(of, statistic, options, range); });
  }
  const CrossedResults chosen = without_names(objects);
  scores.all =
      scores_of(runs, [&](const Statistic& statistic) { return figure_over_objects(chosen, statistic, options, range); });
  return scores;
}

}  // namespace tactile::evaluation
