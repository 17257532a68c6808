#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tactile/core/touch.hpp"
#include "tactile/evaluation/crossed_figure.hpp"
#include "tactile/results/accuracy.hpp"
#include "tactile/results/confusion.hpp"
#include "tactile/results/unseen_comparison.hpp"

namespace tactile::evaluation {

/// Counts pairs of true and predicted class. @throws Error  if the two are not of one length
results::Confusion confusion_of(std::span<const Touch> truth, std::span<const Touch> predicted);

bool has_samples(const results::RunConfusion& run);

/// The share of correct samples, over all samples of these runs; nothing without samples.
std::optional<double> accuracy_over(std::span<const results::RunConfusion> runs, std::span<const std::size_t> indexes);

/// Of shares of samples: [0, 1], in steps of one sample of a run.
Range range_of_shares(std::span<const results::RunConfusion> runs);

/// Runs without samples are left out.
results::Accuracy accuracy_of(std::span<const results::RunConfusion> runs, const results::BootstrapOptions& options = {});

/// Where the variance of the mean accuracy over objects comes from; nothing as `variance_shares`.
std::optional<results::VarianceShares> variance_of_accuracy(std::span<const results::RunConfusion> runs);

/// `b - a` of the same runs in the same order, in each draw too. @throws Error  if they are not the same runs
results::Accuracy accuracy_difference(std::span<const results::RunConfusion> a, std::span<const results::RunConfusion> b,
                                      const results::BootstrapOptions& options = {});

/// Compares verdicts on the same runs with their objects in training and without; the names of models and runs stay empty.
/// @throws Error  as `accuracy_difference`
results::UnseenComparison unseen_comparison(std::span<const results::RunConfusion> seen,
                                            std::span<const results::RunConfusion> held_out,
                                            const results::BootstrapOptions& options = {});

}  // namespace tactile::evaluation
