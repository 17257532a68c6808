#include "tactile/evaluation/accuracy.hpp"

#include <functional>

#include "tactile/core/error.hpp"

namespace tactile::evaluation {
namespace {

results::Accuracy accuracy_by(std::span<const results::RunConfusion> runs,
                              const std::function<std::optional<double>(std::span<const std::size_t>)>& of_runs,
                              const Range& range, const results::BootstrapOptions& options) {
  const auto objects = results_by_object(runs, has_samples);
  results::Accuracy accuracy;
  for (const auto& [name, cells] : objects)
    accuracy.objects[name] = figure_of_object(cells, mean_over_objects(of_runs), options, range);
  accuracy.mean = figure_over_objects(without_names(objects), mean_over_objects(of_runs), options, range);
  return accuracy;
}

}  // namespace

bool has_samples(const results::RunConfusion& run) { return run.confusion.samples() > 0; }

std::optional<double> accuracy_over(std::span<const results::RunConfusion> runs, std::span<const std::size_t> indexes) {
  std::uint64_t correct = 0, samples = 0;
  for (const std::size_t i : indexes) {
    correct += runs[i].confusion.correct();
    samples += runs[i].confusion.samples();
  }
  if (samples == 0) return std::nullopt;
  return static_cast<double>(correct) / static_cast<double>(samples);
}

results::Confusion confusion_of(std::span<const Touch> truth, std::span<const Touch> predicted) {
  if (truth.size() != predicted.size()) {
    throw Error("confusion: " + std::to_string(truth.size()) + " samples but " + std::to_string(predicted.size()) +
                " verdicts; expected one each");
  }
  results::Confusion confusion;
  for (std::size_t i = 0; i < truth.size(); ++i) confusion.add(truth[i], predicted[i]);
  return confusion;
}

Range range_of_shares(std::span<const results::RunConfusion> runs) {
  double samples = 0, filled = 0;
  for (const results::RunConfusion& run : runs) {
    samples += static_cast<double>(run.confusion.samples());
    filled += run.confusion.samples() > 0 ? 1 : 0;
  }
  return {0, 1, samples > 0 ? filled / samples : 0};
}

results::Accuracy accuracy_of(std::span<const results::RunConfusion> runs, const results::BootstrapOptions& options) {
  return accuracy_by(
      runs, [runs](std::span<const std::size_t> indexes) { return accuracy_over(runs, indexes); }, range_of_shares(runs),
      options);
}

std::optional<results::VarianceShares> variance_of_accuracy(std::span<const results::RunConfusion> runs) {
  const auto objects = results_by_object(runs, has_samples);
  return variance_shares(without_names(objects), mean_over_objects([runs](std::span<const std::size_t> indexes) {
                           return accuracy_over(runs, indexes);
                         }));
}

results::Accuracy accuracy_difference(std::span<const results::RunConfusion> a, std::span<const results::RunConfusion> b,
                                      const results::BootstrapOptions& options) {
  bool same = a.size() == b.size();
  for (std::size_t i = 0; same && i < a.size(); ++i) {
    same = a[i].object == b[i].object && a[i].run == b[i].run && a[i].training == b[i].training;
  }
  if (!same) throw Error("difference of accuracies: different runs; expected the same runs in the same order");
  return accuracy_by(
      a,
      [a, b](std::span<const std::size_t> indexes) -> std::optional<double> {
        const auto first = accuracy_over(a, indexes), second = accuracy_over(b, indexes);
        if (!first || !second) return std::nullopt;
        return *second - *first;
      },
      {-1, 1, range_of_shares(a).step}, options);
}

results::UnseenComparison unseen_comparison(std::span<const results::RunConfusion> seen,
                                            std::span<const results::RunConfusion> held_out,
                                            const results::BootstrapOptions& options) {
  const results::Accuracy with = accuracy_of(seen, options), without = accuracy_of(held_out, options);
  const results::Accuracy difference = accuracy_difference(seen, held_out, options);
  results::UnseenComparison comparison;
  comparison.mean = {with.mean, without.mean, difference.mean};
  for (const auto& [name, figure] : with.objects)
    comparison.objects[name] = {figure, without.objects.at(name), difference.objects.at(name)};
  return comparison;
}

}  // namespace tactile::evaluation
