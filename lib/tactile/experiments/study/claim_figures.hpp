#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>

#include "tactile/evaluation/crossed_figure.hpp"
#include "tactile/experiments/study/claim_rules.hpp"
#include "tactile/results/claim.hpp"

namespace tactile::study {

/// A claim that has no measurement yet.
results::Claim unmeasured(std::string id, results::ClaimScope scope, std::string claim, std::string paper, std::string unit,
                          results::Asked asked, double limit);

/// Intervals that hold for `count` objects at once.
results::BootstrapOptions wide_for(std::size_t count, results::BootstrapOptions options);

/// Sets the objects' figures, the outermost of them as the measured one, and the number of objects that the claim is true for.
void take(results::Claim& claim, ObjectFigures figures, const results::Figure& mean);

/// A figure of one object by its runs; nothing where there is nothing to measure.
using OfRuns = std::function<std::optional<double>(std::span<const std::size_t>)>;

/// The same by a figure of each object.
void take(results::Claim& claim, const std::map<std::string, evaluation::CrossedObject>& objects, const OfRuns& of_runs,
          const evaluation::Range& range, const results::BootstrapOptions& options);

/// The object whose value is `claim.measured`.
std::string furthest_object(const results::Claim& claim);

/// "3 of 10 objects", "1 of 1 object"
std::string kept_of(const results::Claim& claim);

}  // namespace tactile::study
