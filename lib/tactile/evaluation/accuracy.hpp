#pragma once

#include <optional>
#include <span>
#include <vector>

#include "tactile/evaluation/run_figures.hpp"
#include "tactile/results/accuracy.hpp"
#include "tactile/results/cell.hpp"
#include "tactile/results/unseen_comparison.hpp"

namespace tactile::evaluation {

/// Whether the cell has balanced samples.
bool has_samples(const results::Cell& cell);

/// The share of correct samples, over all samples of these cells; nothing without samples.
std::optional<double> accuracy_over(std::span<const results::Cell> cells, std::span<const std::size_t> indexes);

/// Of shares of samples: [0, 1], in steps of one sample of a cell.
Range range_of_shares(std::span<const results::Cell> cells);

/// Cells without samples are left out.
results::Accuracy accuracy_of(std::span<const results::Cell> cells, const results::BootstrapOptions& options = {});

/// `b - a` of the same runs in the same order, in each draw too. @throws Error  if they are not the same runs
results::Accuracy accuracy_difference(std::span<const results::Cell> a, std::span<const results::Cell> b,
                                      const results::BootstrapOptions& options = {});

/// Compares verdicts on the same runs with their objects in training and without; the names of the models stay empty.
/// @throws Error  as `accuracy_difference`
results::UnseenComparison unseen_comparison(std::span<const results::Cell> seen, std::span<const results::Cell> held_out,
                                            const results::BootstrapOptions& options = {});

/// The samples of all cells together.
results::Confusion confusion_of(std::span<const results::Cell> cells);

}  // namespace tactile::evaluation
