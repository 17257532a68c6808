#include "tactile/experiments/study/claim_figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace tactile::study {

results::Claim unmeasured(std::string id, results::ClaimScope scope, std::string claim, std::string paper, std::string unit,
                          results::Asked asked, double limit) {
  results::Claim empty;
  empty.id = std::move(id);
  empty.scope = scope;
  empty.claim = std::move(claim);
  empty.paper = std::move(paper);
  empty.unit = std::move(unit);
  empty.asked = asked;
  empty.limit = limit;
  return empty;
}

results::BootstrapOptions wide_for(std::size_t count, results::BootstrapOptions options) {
  options.confidence = 1 - (1 - options.confidence) / static_cast<double>(std::max<std::size_t>(count, 1));
  return options;
}

void take(results::Claim& claim, ObjectFigures figures, const results::Figure& mean) {
  claim.mean = mean;
  claim.measured = claim.asked == results::Asked::below ? largest_of(figures) : smallest_of(figures);
  claim.objects = std::move(figures.objects);
  claim.kept = 0;
  claim.of = 0;
  for (const auto& [name, figure] : claim.objects) {
    if (std::isnan(figure.value)) continue;
    ++*claim.of;
    *claim.kept += (claim.asked == results::Asked::below ? figure.value < claim.limit : figure.value > claim.limit) ? 1U : 0U;
  }
}

void take(results::Claim& claim, const std::map<std::string, evaluation::CrossedObject>& objects, const OfRuns& of_runs,
          const evaluation::Range& range, const results::BootstrapOptions& options) {
  const evaluation::Statistic mean = evaluation::mean_over_objects(of_runs);
  ObjectFigures figures;
  for (const auto& [name, cells] : objects) {
    figures.objects[name] = evaluation::figure_of_object(cells, mean, options, range);
    figures.wide[name] = evaluation::figure_of_object(cells, mean, wide_for(objects.size(), options), range);
  }
  take(claim, std::move(figures), evaluation::figure_of_these_objects(evaluation::without_names(objects), mean, options, range));
}

std::string furthest_object(const results::Claim& claim) {
  for (const auto& [name, figure] : claim.objects) {
    if (figure.value == claim.measured.value) return name;
  }
  return {};
}

std::string kept_of(const results::Claim& claim) {
  return fmt::format("{} of {} object{}", claim.kept.value_or(0), claim.of.value_or(0), claim.of == std::size_t{1} ? "" : "s");
}

}  // namespace tactile::study
