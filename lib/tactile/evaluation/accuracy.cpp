#include "tactile/evaluation/accuracy.hpp"

#include <functional>
#include <set>
#include <string>

#include "tactile/core/error.hpp"

namespace tactile::evaluation {
namespace {

results::Accuracy accuracy_by(std::span<const results::Cell> cells,
                              const std::function<std::optional<double>(std::span<const std::size_t>)>& of_runs,
                              const Range& range, const results::BootstrapOptions& options) {
  const Statistic mean = mean_over_objects(of_runs);
  results::Accuracy accuracy;
  for (const std::string& object : objects_of(cells, has_samples)) {
    const RunFigures of_object(cells, &options,
                               [&](const results::Cell& cell) { return has_samples(cell) && cell.object == object; });
    accuracy.objects[object] = of_object.of_objects(mean, range);
  }
  accuracy.mean = RunFigures(cells, &options, has_samples).of_objects(mean, range);
  return accuracy;
}

}  // namespace

bool has_samples(const results::Cell& cell) { return cell.samples.samples() > 0; }

std::optional<double> accuracy_over(std::span<const results::Cell> cells, std::span<const std::size_t> indexes) {
  results::Confusion sum;
  for (const std::size_t i : indexes) sum += cells[i].samples;
  return sum.accuracy();
}

Range range_of_shares(std::span<const results::Cell> cells) {
  double samples = 0, filled = 0;
  for (const results::Cell& cell : cells) {
    samples += static_cast<double>(cell.samples.samples());
    filled += has_samples(cell) ? 1 : 0;
  }
  return {0, 1, samples > 0 ? filled / samples : 0};
}

results::Accuracy accuracy_of(std::span<const results::Cell> cells, const results::BootstrapOptions& options) {
  return accuracy_by(
      cells, [cells](std::span<const std::size_t> indexes) { return accuracy_over(cells, indexes); }, range_of_shares(cells),
      options);
}

results::Accuracy accuracy_difference(std::span<const results::Cell> a, std::span<const results::Cell> b,
                                      const results::BootstrapOptions& options) {
  bool same = a.size() == b.size();
  for (std::size_t i = 0; same && i < a.size(); ++i) {
    same = a[i].world == b[i].world && a[i].object == b[i].object && a[i].run == b[i].run && a[i].training == b[i].training;
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

results::UnseenComparison unseen_comparison(std::span<const results::Cell> seen, std::span<const results::Cell> held_out,
                                            const results::BootstrapOptions& options) {
  const results::Accuracy with = accuracy_of(seen, options), without = accuracy_of(held_out, options);
  const results::Accuracy difference = accuracy_difference(seen, held_out, options);
  results::UnseenComparison comparison;
  comparison.mean = {with.mean, without.mean, difference.mean};
  for (const auto& [name, figure] : with.objects)
    comparison.objects[name] = {figure, without.objects.at(name), difference.objects.at(name)};
  std::set<std::string> runs;
  for (const results::Cell& cell : seen) runs.insert(cell.object + "/" + cell.run);
  comparison.runs.assign(runs.begin(), runs.end());
  return comparison;
}

results::Confusion confusion_of(std::span<const results::Cell> cells) {
  results::Confusion sum;
  for (const results::Cell& cell : cells) sum += cell.samples;
  return sum;
}

}  // namespace tactile::evaluation
